"""Some damaged .blend files with every test run; `python -m tests.fuzz.blends 1000` tries more."""

from .blends import hunt, save_base


def test_damaged_blends_are_read_or_refused(tmp_path):
    """Blender's own reader dies of one in fifty; whatever comes back to Python is a picture's scene or a message."""
    killed, answers = hunt(save_base(tmp_path), 60, 7)
    assert not [answer for answer in answers if answer.startswith("WRONG")]
    assert len(answers) + len(killed) == 60 and len(killed) < 10, killed
    assert sum(answer.startswith("0") for answer in answers) > 2, "some are read"


def test_compressed_ones_too(tmp_path):
    killed, answers = hunt(save_base(tmp_path, compress=True), 20, 8)
    assert not killed and not [answer for answer in answers if answer.startswith("WRONG")]
