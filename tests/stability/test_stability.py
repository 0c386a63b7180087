"""The short cases with every test run; all of them by `make stability`, or with PHOTON_MAP_STABILITY=all."""

import os

import pytest

from . import load_cases

ALL = os.environ.get("PHOTON_MAP_STABILITY") == "all"
CASES = [item for item in load_cases() if item.short or ALL]


@pytest.mark.parametrize("item", CASES, ids=[f"{item.family}: {item.name}" for item in CASES])
def test_law_holds(item):
    found = item.check()
    print(f"{item.law}: {found.figure}")
    assert found.good != bool(item.known), f"{item.law}: {found.figure} {item.known}"


def test_each_case_has_its_own_name():
    names = [(item.family, item.name) for item in load_cases()]
    assert len(set(names)) == len(names) >= 60
