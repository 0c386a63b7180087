"""The report's figures, plot, table and refusals; renders are made up."""

import argparse
import json
import sys

import numpy as np
import OpenImageIO as oiio
import pytest

from ...issues import RenderError
from .. import command
from ..metrics import Errors, errors, noise_figure
from ..plot import DPI, PANEL, plot
from ..reference import Known, write_reference
from ..runs import Run


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
    found = errors(x, Known(reference))
    part = 16 / 768
    assert found.relMSE == pytest.approx(part / 0.26, rel=1e-6) and found.RMSE == pytest.approx(part**0.5, rel=1e-6)
    assert found.mean_ratio == pytest.approx(1.0 + part / 0.5, rel=1e-6)
    assert found.p99 == pytest.approx(0.26**-0.5, rel=1e-6) and 0.0 < found.FLIP < 0.2
    assert errors(reference, Known(reference)) == Errors(0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    assert found.relMSE999 == pytest.approx(15 / 767 / 0.26, rel=1e-6)  # 0.1% is one pixel of 768


def test_noise_of_the_reference_is_not_told_as_the_pictures(tmp_path):
    rng = np.random.default_rng(1)
    size, se = (128, 128, 3), np.full((128, 128, 3), 0.03, np.float32)
    reference = (0.5 + 0.03 * rng.normal(size=size)).astype(np.float32)
    x = (0.5 + 0.03 * rng.normal(size=size)).astype(np.float32)
    found = errors(x, Known(reference, se))
    # the mean of 49152 squares is known to 0.6%, half of it to 1.3%; noise in the divisor adds 3%
    assert found.RMSE == pytest.approx(0.03, rel=0.02) and errors(x, Known(reference)).RMSE > 0.04
    assert found.relMSE == pytest.approx(0.03**2 / 0.26, rel=0.06)
    # one figure for all channels, as components have it, takes off the same
    assert errors(x, Known(reference, se[..., :1])) == found
    assert noise_figure(Known(reference, se)) == pytest.approx(0.03**2 / 0.26, rel=0.03)
    assert noise_figure(Known(reference)) == 0.0


def test_few_pixels_that_the_reference_missed_do_not_rule_the_trimmed_figure():
    """A lamp's image of 5 pixels that no path of the reference met, so that its standard error is 0 there."""
    rng = np.random.default_rng(2)
    se = np.full((128, 128, 3), 0.02, np.float32)
    truth = picture(0.3, (128, 128))
    truth[60, 60:65] = 40.0
    reference = (truth + 0.02 * rng.normal(size=truth.shape)).astype(np.float32)
    reference[60, 60:65], se[60, 60:65] = 0.0, 0.0
    x = (truth + 0.05 * rng.normal(size=truth.shape)).astype(np.float32)
    found = errors(x, Known(reference, se))
    assert found.relMSE == pytest.approx(5 / 128**2 * 40.0**2 / 0.01, rel=0.01)
    # of noise alone: means of 49152 squares, 1%; the reference's noise in the divisor, 1%; the rest of the 16 worst, 1%
    assert found.relMSE999 == pytest.approx(0.05**2 / 0.1, rel=0.03)


def test_less_than_the_doubt_of_the_reference_is_not_told():
    """One bright pixel that few paths of the reference met: it happens to be nearer than its standard error."""
    truth, se = picture(0.5, (128, 128)), picture(0.01, (128, 128))
    reference = (truth + 0.01 * np.random.default_rng(3).normal(size=truth.shape)).astype(np.float32)
    se[5, 7], reference[5, 7], truth[5, 7] = 30.0, 40.0, 30.0
    found = errors(truth, Known(reference, se))
    assert found.RMSE == pytest.approx((2.0**0.5 * 30.0**2 / 128**2) ** 0.5, rel=0.01)  # 10^2 - 30^2 is below 0
    pixel = 2.0**0.5 * 30.0**2 / 40.0**2 / 128**2  # of relMSE; all others together have 1% of their 3.8e-4
    assert found.relMSE == pytest.approx(pixel, rel=0.05)
    # without that pixel the doubt is 2^0.5 / 128 of the others' noise, and the difference within a few of it
    doubt = 2.0**0.5 / 128 * 0.01**2 / 0.26
    assert 0.9 * doubt < found.relMSE999 < 4.0 * doubt


def test_a_picture_of_one_pixel_has_a_trimmed_figure():
    assert errors(picture(0.6, (1, 1)), Known(picture(0.5, (1, 1)))).relMSE999 == pytest.approx(0.01 / 0.26, rel=1e-5)


def test_other_size_is_refused_with_the_remedy():
    with pytest.raises(RenderError, match=r"is 32 x 24, the picture 16 x 24 \(render with --resolution 32 x 24\)"):
        errors(picture(size=(24, 16)), Known(picture()))


@pytest.mark.parametrize("module", ["matplotlib", "flip_evaluator"])
def test_missing_package_is_named(module, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(RenderError, match=r"is not installed \(pip install -r requirements-dev.txt\)"):
        if module == "matplotlib":
            command.run(arguments(tmp_path), lambda text: None)
        errors(picture(), Known(picture()))


def test_a_reference_is_of_one_scene(tmp_path):
    given = arguments(tmp_path, "--reference", str(tmp_path / "ours.exr"))
    with pytest.raises(RenderError, match="several"):
        command.run(argparse.Namespace(**{**vars(given), "scenes": given.scenes * 2}), lambda text: None)


@pytest.mark.parametrize("text", ["", "1,x", "0", "-1,2"])
def test_bad_seconds(text, tmp_path, capsys):
    with pytest.raises(SystemExit):
        arguments(tmp_path, "--seconds", text)
    assert "seconds" in capsys.readouterr().err


LEVEL = {"Combined": 0.5, "Caustic": 0.1, "Direct": 0.4}
NOISE = {"Combined": 0.1, "Caustic": 0.05, "Direct": 0.2}  # standard deviation after a second
SE = 2.0**-7  # of the reference: half floats hold it


def fake_ours(task, seconds, denoise, place):
    rng = np.random.default_rng(int(seconds))
    noise = {name: rng.normal(0.0, scale / seconds**0.5, (24, 32, 3)) for name, scale in NOISE.items()}
    pictures = {name: (picture(LEVEL[name]) + noise[name]).astype(np.float32) for name in NOISE}
    return Run(seconds, 0.5, {"passes": 3}, pictures | {"Emission": picture(0.0)}, 2.0 * seconds)


def fake_cycles(task, seconds, denoise, place):
    assert task.threads == 2 and task.resolution == (32, 24)
    return Run(1.1 * seconds, 0.5, {}, {"Combined": picture(0.7)}, 2.2 * seconds)


@pytest.fixture
def renders(monkeypatch):
    """Renders made up, of 32 x 24 pixels."""
    monkeypatch.setattr(command, "ours", fake_ours)
    monkeypatch.setattr(command, "cycles", fake_cycles)


def test_report_holds_every_engine_and_component(tmp_path, renders):
    whole, parts = tmp_path / "whole.exr", tmp_path / "parts.exr"
    se = picture(SE)
    write_reference(whole, {"Combined": Known(picture(), se)}, {})
    # another Combined, which does not count, and a component that the scene does not have
    levels = LEVEL | {"Combined": 0.9, "Emission": 0.0}
    write_reference(parts, {name: Known(picture(level)) for name, level in levels.items()}, {})
    said = []
    flags = ("--against", "cycles", "--threads", "2", "--reference", str(whole), "--reference", str(parts))
    command.run(arguments(tmp_path, *flags), said.append)
    record = json.loads((tmp_path / "out" / "room.json").read_text())
    lines = {(point["engine"], point["part"]) for point in record["points"]}
    assert lines == {("Photon Map", "Combined"), ("Photon Map", "Caustic"), ("Photon Map", "Direct"),
                     ("Photon Map, denoised", "Combined"), ("Cycles", "Combined"),
                     ("Cycles, denoised", "Combined")}  # fmt: skip
    for name, level in LEVEL.items():
        mine = [p for p in record["points"] if (p["engine"], p["part"]) == ("Photon Map", name)]
        known = SE**2 if name == "Combined" else 0.0
        truth = [(NOISE[name] ** 2 / s - known) / (level**2 + 0.01) for s in (1, 2, 4)]
        assert [point["relMSE"] for point in mine] == pytest.approx(truth, rel=0.1)  # of 2304 values: 3%
        assert all(0.95 * p["relMSE"] < p["relMSE999"] < p["relMSE"] for p in mine)  # one of 768 pixels, ten times it
    assert record["machine"]["cores"] and record["threads"] == 2
    sources = dict.fromkeys(("Combined", "Direct", "Caustic", "Emission"), str(parts))
    assert record["reference"] == sources | {"Combined": str(whole)}
    assert record["reference_relMSE"] == {"Combined": pytest.approx(SE**2 / 0.26)}
    place = tmp_path.name
    assert f"Combined: {place}/whole.exr; Direct, Caustic, Emission: {place}/parts.exr" in said[0]
    assert "room.svg" in said[-1]
    raw = record["against"][0]
    assert (raw["pictures"], raw["figure"], raw["clock"], raw["bound"]) == ("raw", "relMSE", "seconds", ">")
    assert raw["times"] == pytest.approx(4.4) and raw["stays"] == pytest.approx((0.04 - SE**2) / 0.26, rel=1e-4)
    assert said[-9].startswith("raw: at least 4.4 times faster to equal relMSE in")
    assert said[-2].startswith("denoised: at least 4.4 times faster to equal relMSE999 in processor")
    assert all((tmp_path / "out" / f"room.{kind}").stat().st_size > 5000 for kind in ("png", "svg"))
    # a block of rows for each line, engines before components, named in the first row
    rows = said[-10].splitlines()
    names = [row[:35].strip() for row in rows]
    engines = ("Photon Map", "Photon Map, denoised", "Cycles", "Cycles, denoised")
    wholes = [f"{engine:<22}Combined" for engine in engines]
    assert names[0].split() == ["engine", "picture"]
    assert names[1::3] == [*wholes, f"{'Photon Map':<22}Caustic", f"{'Photon Map':<22}Direct"]
    assert not any(names[2::3]) and not any(names[3::3]) and len(set(map(len, rows))) == 1


def test_without_a_reference_a_long_run_is_told_as_ours(tmp_path, renders):
    said = []
    command.run(arguments(tmp_path, "--resolution", "32x24"), said.append)
    record = json.loads((tmp_path / "out" / "room.json").read_text())
    assert set(record["reference"]) == {"Combined", "Direct", "Caustic", "Emission"} and not record["reference_relMSE"]
    assert all(source.startswith("ours, 32 s with caustic_radius=1") for source in record["reference"].values())
    assert {point["part"] for point in record["points"]} == {"Combined", "Direct", "Caustic"}


@pytest.mark.parametrize(("parts", "panels"), [(("Combined",), 1), (("Combined", "Caustic", "Direct"), 2)])
def test_components_have_a_panel_of_their_own(parts, panels, tmp_path):
    shared = {"engine": "Photon Map", "relMSE": 0.1, "relMSE999": 0.05}
    points = [{**shared, "part": part, "seconds": s + 0.1, "asked_seconds": s} for part in parts for s in (1.0, 2.0)]
    png, svg = plot(points, "room", "held against Combined: a/whole.exr", tmp_path / "room")
    spec = oiio.ImageInput.open(str(png)).spec()
    assert (spec.width, spec.height) == (round(PANEL[0] * panels * DPI), round(PANEL[1] * DPI))
    drawn = svg.read_text()
    assert all(f"<!-- {text} -->" in drawn for text in ("room", "held against Combined: a/whole.exr", *parts[1:]))
