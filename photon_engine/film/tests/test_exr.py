import numpy as np
import OpenImageIO as oiio
import pytest

from ...scene.data import Frame
from ..exr import read_exr, srgb, write_exr, write_sheet
from ..output import OutputError, check_writable
from ..passes import PASSES, in_full_frame


def pictures(height, width):
    rng = np.random.default_rng(1)
    return {p.name: rng.uniform(-2.0, 50.0, (height, width, p.channels)).astype(np.float32) for p in PASSES}


def test_exr_keeps_every_bit_and_its_metadata(tmp_path):
    path = tmp_path / "a.exr"
    before = pictures(6, 9)
    before["Depth"][0, 0] = 1e10
    write_exr(path, before, "View Layer", {"seed": 3, "scene": "Scène", "settings": {"alpha": 0.5}})
    after, meta = read_exr(path)
    assert set(after) == {p.name for p in PASSES}
    for name in before:
        np.testing.assert_array_equal(after[name], before[name])
    assert meta == {"seed": "3", "scene": "Scène", "settings": '{"alpha": 0.5}'}


def test_exr_has_blenders_channel_names_and_the_top_row_first(tmp_path):
    path = tmp_path / "a.exr"
    before = pictures(4, 3)
    write_exr(path, before, "ViewLayer")
    buffer = oiio.ImageBuf(str(path))
    names = set(buffer.spec().channelnames)
    assert {"ViewLayer.Combined.A", "ViewLayer.Caustic.R", "ViewLayer.Depth.Z", "ViewLayer.Normal.X"} <= names
    assert len(names) == sum(p.channels for p in PASSES)
    z = list(buffer.spec().channelnames).index("ViewLayer.Depth.Z")
    np.testing.assert_array_equal(buffer.get_pixels(oiio.FLOAT)[0, :, z], before["Depth"][-1, :, 0])


def test_sheet_is_four_pictures(tmp_path):
    path = tmp_path / "a.png"
    four = {p.name: np.zeros((8, 10, p.channels), np.float32) for p in PASSES}
    four["Combined"][-1, 0, :3] = 1.0  # bottom row first: the upper left corner
    four["Diffuse"][0, -1, :3] = 0.5
    write_sheet(path, four)
    pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)
    assert pixels.shape == (16, 20, 3)
    assert pixels[0, 0].tolist() == [255] * 3
    assert pixels[-1, -1].tolist() == [188] * 3  # sRGB of 0.5
    assert np.count_nonzero(pixels) == 6


def test_big_sheet_is_labelled(tmp_path):
    four = {p.name: np.zeros((128, 160, p.channels), np.float32) for p in PASSES}
    write_sheet(tmp_path / "a.png", four)
    pixels = oiio.ImageBuf(str(tmp_path / "a.png")).get_pixels(oiio.UINT8)
    assert all((tile > 128).any() for half in np.split(pixels, 2) for tile in np.split(half, 2, axis=1))


def test_srgb_known_values():
    # code values of IEC 61966-2-1: 0.2140 is middle grey 0.5, the linear part ends at 0.04045
    np.testing.assert_allclose(srgb(np.array([-1.0, 0.0, 0.0031308, 0.21404114, 1.0, 9.0])),
                               [0.0, 0.0, 0.04045, 0.5, 1.0, 1.0], atol=1e-5)  # fmt: skip


def test_border_lies_in_the_full_frame_unless_cropped():
    frame = Frame(width=8, height=6, x0=2, y0=1, x1=5, y1=3)
    part = np.ones((2, 3, 4), np.float32)
    full = in_full_frame(part, frame)
    assert full.shape == (6, 8, 4) and full.sum() == part.sum() and full[1, 2, 0] == 1.0 and full[3, 2, 0] == 0.0
    frame.crop = True
    assert in_full_frame(part, frame) is part


def test_unwritable_places_are_named_before_and_after(tmp_path):
    (tmp_path / "file").write_text("x")
    for path in (tmp_path / "none" / "a.exr", tmp_path / "file" / "a.exr", tmp_path, "/proc/a.exr"):
        with pytest.raises(OutputError):
            check_writable(path)
        with pytest.raises(OutputError):
            write_exr(path, pictures(2, 2), "ViewLayer")
    with pytest.raises(OutputError):
        write_sheet(tmp_path / "a.unknown", pictures(2, 2))
    check_writable(tmp_path / "new.exr")
    check_writable(tmp_path / "file")
    assert (tmp_path / "file").read_text() == "x" and len(list(tmp_path.iterdir())) == 1
