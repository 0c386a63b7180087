"""A part of the malformed files with every test run; `python -m tests.fuzz 5000` tries more."""

import time

import numpy as np
import pytest

from photon_engine import cli
from photon_engine.issues import RenderError
from photon_engine.scene.io import load_scene
from photon_engine.settings import FIELDS

from .__main__ import attempt, hunt
from .base import save_base
from .mutate import bombs, write

WORDS = (
    "", "-1", "0", "1e400", "nan", "inf", "-inf", "x", "=", "==", "1=2=3", "ä", "None", "true", "1,2", "0x10",
    "9" * 400, "1e-400", " ", "--", "passes=", "=3", "passes=1e9", "alpha=nan", "seed=-1", "threads=2.5",
    "final_gather=none",
)  # fmt: skip
FLAGS = (
    "--passes", "--seconds", "--error", "--error-share", "--error-pass", "--seed", "--threads", "--set", "--first",
    "--frame", "--frames", "--resolution", "--camera", "--only", "-o", "--state", "--resume", "--log",
)  # fmt: skip


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    return save_base(tmp_path_factory.mktemp("base"))


def test_the_scene_itself_renders(base):
    assert attempt(base) == ""


def test_no_file_breaks_it(base):
    """In a process of its own: a kernel that reads out of bounds would take this one with it."""
    broken, answers = hunt(base, 250, 2)
    assert not broken, "\n".join(broken)
    pictures = answers.count("a picture")
    assert 10 < pictures < 100 and len(answers) == 250, "files reach the renderer, and most are refused"


@pytest.mark.parametrize("name", sorted(bombs()))
def test_what_claims_to_be_large_or_is_something_else_is_refused_at_once(name, tmp_path):
    path = write(tmp_path / "bomb.npz", bombs()[name])
    start = time.process_time()
    with pytest.raises(RenderError, match=r"not a scene|damaged"):
        load_scene(path)
    assert time.process_time() - start < 2.0, "0.01 s measured; 2 s for a loaded machine"


def test_no_word_on_the_command_line_breaks_it(base, tmp_path, monkeypatch, capsys):
    """Every flag with every odd word: a message and an exit code for bad input, never the one of a bug."""
    monkeypatch.chdir(tmp_path)
    allowed = {cli.USAGE, cli.BAD_INPUT, cli.BAD_OUTPUT}
    missing = tmp_path / "missing.npz"
    rng = np.random.default_rng(4)
    pairs = [(flag, word) for flag in FLAGS for word in WORDS]
    pairs += [("--set", f"{name}={word}") for name in FIELDS for word in rng.choice(WORDS, 4)]
    for flag, word in pairs:
        try:
            code = cli.main(["render", str(missing), flag, word, "--no-sheet"])
        except SystemExit as stop:  # argparse
            code = stop.code
        said = capsys.readouterr().err
        assert code in allowed and "error" in said and "Traceback" not in said, (flag, word, code, said)
