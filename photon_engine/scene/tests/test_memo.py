"""What is kept is what equal inputs gave before; anything else is made anew."""

from dataclasses import replace

import numpy as np
import pytest

from ...issues import IssueLog, RenderError
from ..data import Graph, Light, Material, Node, Socket
from ..memo import Memo, same


def material(rough=0.5, curve=(0.0, 1.0)):
    """A graph with numbers, lists and arrays in it; all objects are new ones."""
    node = Node("ShaderNodeRGBCurve", "Curves", {"table": np.array(curve)}, {"Fac": Socket(rough)}, {"Color": "RGBA"})
    return Material("A", Graph([node], Socket(None, 0, "Color", "RGBA")))


def test_equal_records_are_the_same_and_any_difference_is_seen():
    assert same(material(), material())
    assert not same(material(), material(rough=0.6)) and not same(material(), material(curve=(0.0, 0.9)))
    light = Light("L", "POINT", np.eye(4), (1.0, 1.0, 1.0))
    assert same(light, replace(light, matrix=np.eye(4))) and not same(light, replace(light, matrix=2.0 * np.eye(4)))
    assert not same(np.zeros(2, np.float32), np.zeros(2)) and not same((1,), (1, 2)) and not same({"a": 1}, {"b": 1})
    assert not same(np.array([np.nan]), np.array([np.nan])) and not same(None, 0) and not same(True, 1)


def test_made_once_for_equal_inputs_and_again_for_others():
    memo, issues = Memo(), IssueLog()
    first = memo.get("x", (np.zeros(3), material()), lambda own: [1], issues)
    assert memo.get("x", (np.zeros(3), material()), lambda own: [2], issues) is first
    assert memo.get("y", (np.zeros(3), material()), lambda own: [3], issues) == [3]
    assert memo.get("x", (np.ones(3), material()), lambda own: [4], issues) == [4]
    assert memo.made == {"x": 2, "y": 1}


def test_issues_are_told_each_time_and_also_when_it_fails():
    memo = Memo()

    def make(own):
        own.warn("Lamp", "negative")
        return 1

    for _ in range(2):
        issues = IssueLog()
        memo.get("x", (1,), make, issues)
        assert [item.object for item in issues] == ["Lamp"]

    def fail(own):
        own.warn("Lamp", "not finite")
        raise RenderError("Lamp", "no light")

    issues = IssueLog()
    with pytest.raises(RenderError):
        memo.get("x", (2,), fail, issues)
    assert [item.message for item in issues] == ["not finite"] and memo.made["x"] == 1
    assert memo.get("x", (1,), lambda own: 5, issues) == 1  # what was there before still is


def test_what_nobody_asks_for_is_forgotten():
    memo = Memo()
    memo.get("x", (1,), lambda own: 1, IssueLog())
    memo.drop_unused()
    memo.drop_unused()
    assert memo.get("x", (1,), lambda own: 2, IssueLog()) == 2
