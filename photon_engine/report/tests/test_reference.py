"""Reference pictures on disk, and the choice among several files."""

import re

import numpy as np
import OpenImageIO as oiio
import pytest

from ...film.exr import write_exr
from ...issues import RenderError
from ..reference import Known, choose, coarse, read_reference, write_reference

SIZE = (24, 32)


def picture(value=0.5, size=SIZE, channels=3):
    return np.full((*size, channels), value, np.float32)


def halves(seed, channels=3):
    """Numbers that half floats hold, none like the other."""
    return np.random.default_rng(seed).random((*SIZE, channels)).astype(np.float16).astype(np.float32)


def test_what_is_written_is_read(tmp_path):
    path = tmp_path / "new" / "room.exr"
    known = {"Combined": Known(halves(1), coarse(halves(2))), "Caustic": Known(halves(3), coarse(halves(4, 1))),
             "Direct": Known(halves(5))}  # fmt: skip
    write_reference(path, known, {"spp": 7})
    found, meta = read_reference(path)
    assert meta == {"spp": 7} and set(found) == set(known)
    for name, (mean, se) in known.items():
        np.testing.assert_array_equal(found[name].mean, mean)
        if se is None:
            assert found[name].se is None
        else:
            np.testing.assert_array_equal(found[name].se, se)
    assert oiio.ImageInput.open(str(path)).spec().format == oiio.HALF


def test_a_standard_error_keeps_its_size():
    se = np.random.default_rng(1).lognormal(-5.0, 3.0, (100, 100, 1)).astype(np.float32)
    assert np.abs(coarse(se) / se - 1.0).max() <= 1 / 16 and coarse(np.zeros(3))[0] == 0.0


def test_a_multilayer_render_is_read_by_its_names(tmp_path):
    pictures = {"Combined": picture(channels=4), "Caustic": picture(0.1), "Normal": picture(0.7)}
    write_exr(tmp_path / "ours.exr", pictures, "View Layer")
    known, _ = read_reference(tmp_path / "ours.exr")
    assert set(known) == {"Combined", "Caustic"} and known["Combined"].mean.shape == (*SIZE, 3)
    assert known["Caustic"].mean[0, 0, 0] == np.float32(0.1) and known["Caustic"].se is None


def test_of_each_picture_the_first_file_counts(tmp_path):
    whole, parts, more = (tmp_path / f"{name}.exr" for name in ("whole", "parts", "more"))
    write_reference(whole, {"Combined": Known(picture(1.0))}, {})
    write_reference(parts, {"Combined": Known(picture(2.0)), "Caustic": Known(picture(3.0))}, {})
    write_reference(more, {"Caustic": Known(picture(4.0)), "Direct": Known(picture(5.0))}, {})
    chosen = choose([whole, parts, more])
    assert {name: known.mean[0, 0, 0] for name, known in chosen.pictures.items()} == {
        "Combined": 1.0, "Direct": 5.0, "Caustic": 3.0
    }  # fmt: skip
    assert chosen.sources == {"Combined": str(whole), "Caustic": str(parts), "Direct": str(more)}
    assert chosen.size == (32, 24)
    at = tmp_path.name
    assert chosen.told() == f"Combined: {at}/whole.exr; Caustic: {at}/parts.exr; Direct: {at}/more.exr"
    assert choose([parts, more]).pictures["Combined"].mean[0, 0, 0] == 2.0


def test_files_that_do_not_go_together(tmp_path):
    whole, small, parts = (tmp_path / f"{name}.exr" for name in ("whole", "small", "parts"))
    write_reference(whole, {"Combined": Known(picture())}, {})
    write_reference(small, {"Caustic": Known(picture(size=(12, 16)))}, {})
    write_reference(parts, {"Caustic": Known(picture())}, {})
    with pytest.raises(RenderError, match=rf"{small}: is 16 x 12, {whole} is 32 x 24 \(give references of one size"):
        choose([whole, small])
    with pytest.raises(RenderError, match=rf"{whole}: holds only Combined, as a --reference before it does"):
        choose([whole, whole])
    with pytest.raises(RenderError, match="Combined is in none of the files"):
        choose([parts])


def test_files_that_cannot_be_used(tmp_path):
    def refused(name, message):
        with pytest.raises(RenderError, match=re.escape(str(tmp_path / name)) + f".*{message}"):
            read_reference(tmp_path / name)

    refused("none.exr", "no such file")
    (tmp_path / "bad.png").write_bytes(b"hello")
    refused("bad.png", "cannot be read")
    oiio.ImageBuf(picture()).write(str(tmp_path / "shown.png"), oiio.UINT8)
    refused("shown.png", "not radiance")
    write_exr(tmp_path / "guides.exr", {"Normal": picture()}, "L")
    refused("guides.exr", "holds none of Combined, Direct")
    write_reference(tmp_path / "nan.exr", {"Combined": Known(picture()), "Direct": Known(picture(np.nan))}, {})
    refused("nan.exr", "pixels in Direct that are no finite numbers")
