"""The report's figures, plot, table and refusals; renders are made up."""

import argparse
import json
import sys

import numpy as np
import OpenImageIO as oiio
import pytest

from ...film.exr import write_exr
from ...issues import RenderError
from .. import command
from ..metrics import errors
from ..runs import Run, read_reference


def picture(value=0.5, size=(24, 32)):
    return np.full((*size, 3), value, np.float32)


def arguments(folder, *more):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    scene = folder / "room.blend"
    scene.write_bytes(b"")
    return parser.parse_args([str(scene), "--seconds", "1,2,4", "-o", str(folder / "out"), *more])


def test_errors_are_their_definitions():
    reference = picture(0.5)
    x = reference.copy()
    x[0, :16] = 1.5  # 16 of 768 pixels, 2%, off by 1
    found = errors(x, reference)
    part = 16 / 768
    assert found.relMSE == pytest.approx(part / 0.26, rel=1e-6) and found.RMSE == pytest.approx(part**0.5, rel=1e-6)
    assert found.mean_ratio == pytest.approx(1.0 + part / 0.5, rel=1e-6)
    assert found.p99 == pytest.approx(0.26**-0.5, rel=1e-6) and 0.0 < found.FLIP < 0.2
    assert errors(reference, reference) == (0.0, 0.0, 1.0, 0.0, 0.0)


def test_noise_of_the_reference_is_not_told_as_the_pictures(tmp_path):
    rng = np.random.default_rng(1)
    size, se = (128, 128, 3), np.full((128, 128, 3), 0.03, np.float32)
    reference = (0.5 + 0.03 * rng.normal(size=size)).astype(np.float32)
    x = (0.5 + 0.03 * rng.normal(size=size)).astype(np.float32)
    found = errors(x, reference, se)
    # the mean of 49152 squares is known to 0.6%, half of it to 1.3%; noise in the divisor adds 3%
    assert found.RMSE == pytest.approx(0.03, rel=0.02) and errors(x, reference).RMSE > 0.04
    assert found.relMSE == pytest.approx(0.03**2 / 0.26, rel=0.06)
    layers = np.concatenate([reference, se], axis=2)[::-1]
    spec = oiio.ImageSpec(128, 128, 6, "float")
    spec.channelnames = ("R", "G", "B", "se.R", "se.G", "se.B")
    out = oiio.ImageOutput.create(str(tmp_path / "known.exr"))
    assert out.open(str(tmp_path / "known.exr"), spec) and out.write_image(np.ascontiguousarray(layers))
    out.close()
    known = read_reference(tmp_path / "known.exr")
    np.testing.assert_array_equal(known["Combined"], reference)
    np.testing.assert_array_equal(known["Combined.se"], se)


def test_other_size_is_refused_with_the_remedy():
    with pytest.raises(RenderError, match=r"is 32 x 24, the picture 16 x 24 \(render with --resolution 32 x 24\)"):
        errors(picture(size=(24, 16)), picture())


@pytest.mark.parametrize("module", ["matplotlib", "flip_evaluator"])
def test_missing_package_is_named(module, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(RenderError, match=r"is not installed \(pip install -r requirements-dev.txt\)"):
        if module == "matplotlib":
            command.run(arguments(tmp_path), lambda text: None)
        errors(picture(), picture())


def test_references_that_cannot_be_used(tmp_path):
    with pytest.raises(RenderError, match="no such file"):
        read_reference(tmp_path / "none.exr")
    (tmp_path / "bad.png").write_bytes(b"hello")
    with pytest.raises(RenderError, match="cannot be read"):
        read_reference(tmp_path / "bad.png")
    write_exr(tmp_path / "ours.exr", {"Combined": picture()[..., [0, 0, 0, 0]], "Caustic": picture(0.1)}, "L")
    known = read_reference(tmp_path / "ours.exr")
    assert set(known) == {"Combined", "Caustic"} and known["Combined"].shape == (24, 32, 3)
    with pytest.raises(RenderError, match="several"):
        given = arguments(tmp_path, "--reference", str(tmp_path / "ours.exr"))
        command.run(argparse.Namespace(**{**vars(given), "scenes": given.scenes * 2}), lambda text: None)


@pytest.mark.parametrize("text", ["", "1,x", "0", "-1,2"])
def test_bad_seconds(text, tmp_path, capsys):
    with pytest.raises(SystemExit):
        arguments(tmp_path, "--seconds", text)
    assert "seconds" in capsys.readouterr().err


def test_report_holds_every_engine_and_component(tmp_path, monkeypatch):
    def ours(task, seconds, denoise, place):
        rng = np.random.default_rng(int(seconds))
        noise = rng.normal(0.0, 0.1 / seconds**0.5, (24, 32, 3)).astype(np.float32)
        pictures = {"Combined": picture() + noise, "Caustic": picture(0.1) + noise, "Emission": picture(0.0)}
        return Run(seconds, 0.5, {"passes": 3}, pictures, 2.0 * seconds)

    def cycles(task, seconds, denoise, place):
        assert task.threads == 2 and task.resolution == (32, 24)
        return Run(1.1 * seconds, 0.5, {}, {"Combined": picture(0.7)}, 2.2 * seconds)

    monkeypatch.setattr(command, "ours", ours)
    monkeypatch.setattr(command, "cycles", cycles)
    write_exr(tmp_path / "r.exr", {"Combined": picture()[..., [0, 0, 0, 0]], "Caustic": picture(0.1),
                                   "Emission": picture(0.0)}, "L")  # fmt: skip
    said = []
    flags = ("--against", "cycles", "--threads", "2", "--reference", str(tmp_path / "r.exr"))
    command.run(arguments(tmp_path, *flags), said.append)
    record = json.loads((tmp_path / "out" / "room.json").read_text())
    lines = {(point["engine"], point["part"]) for point in record["points"]}
    assert lines == {("Photon Map", "Combined"), ("Photon Map", "Caustic"), ("Photon Map, denoised", "Combined"),
                     ("Cycles", "Combined"), ("Cycles, denoised", "Combined")}  # fmt: skip
    ours_combined = [p for p in record["points"] if (p["engine"], p["part"]) == ("Photon Map", "Combined")]
    found = [point["relMSE"] for point in ours_combined]
    assert found == pytest.approx([0.01 / s / 0.26 for s in (1, 2, 4)], rel=0.1)  # 2304 values: 3% of their square
    assert record["machine"]["cores"] and record["threads"] == 2
    assert "Photon Map, denoised" in said[-6] and "room.svg" in said[-1]
    raw = record["against"][0]
    assert (raw["pictures"], raw["clock"], raw["bound"]) == ("raw", "seconds", ">")
    assert raw["times"] == pytest.approx(4.4) and raw["stays"] == pytest.approx(0.04 / 0.26, rel=1e-5)
    assert said[-5].startswith("raw: at least 4.4 times faster") and said[-2].startswith("denoised: at least 4.4 times")
    assert all((tmp_path / "out" / f"room.{kind}").stat().st_size > 5000 for kind in ("png", "svg"))
