"""The short cases with every test run; all of them by `make stability`, or with PHOTON_MAP_STABILITY=all."""

import os

import pytest

from . import load_cases
from .table import BEGIN, DOCS, END, FAMILIES, README, sections

ALL = os.environ.get("PHOTON_MAP_STABILITY") == "all"
CASES = [item for item in load_cases() if item.short or ALL]


@pytest.mark.parametrize("item", CASES, ids=[f"{item.family}: {item.name}" for item in CASES])
def test_law_holds(item):
    found = item.check()
    print(f"{item.law}: {found.figure}")
    assert found.good != bool(item.known), f"{item.law}: {found.figure} {item.known}"


def test_the_tables_in_the_documents_have_all_cases():
    """If not: python -m tests.stability --markdown, for the families that changed."""
    cases = load_cases()
    assert {item.family for item in cases} == set(FAMILIES)
    found = sections(DOCS.read_text())
    for family in FAMILIES:
        listed = [line[2:].split(" | ")[:2] for line in found[family].splitlines()[4:]]
        assert listed == [[item.name, item.law] for item in cases if item.family == family], family
    table = README.read_text().partition(BEGIN)[2].partition(END)[0]
    said = {line[2:].split(" | ")[0]: line[2:].split(" | ")[3] for line in table.strip().splitlines()[2:]}
    counts = {family: sum(item.family == family for item in cases) for family in FAMILIES}
    assert said == {family: f"{count} of {count}" for family, count in counts.items()}


def test_each_case_has_its_own_name():
    names = [(item.family, item.name) for item in load_cases()]
    assert len(set(names)) == len(names) >= 60
