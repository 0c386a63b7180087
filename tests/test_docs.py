"""The pages in docs/ name code and tests that exist."""

import ast
import re

import pytest

from tests.test_structure import ROOT

LECTURE = (ROOT / "docs" / "lecture.md").read_text()
PLACES = sorted(set(re.findall(r"`([\w/]+(?:\.py(?::\w+)?|/))`", LECTURE)))


@pytest.mark.parametrize("place", PLACES)
def test_place_exists(place):
    path, _, name = place.partition(":")
    file = next((base / path for base in (ROOT / "photon_engine", ROOT) if (base / path).exists()), None)
    assert file is not None, f"docs/lecture.md names {path}, which is gone"
    if name:
        found = set()
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                found.add(node.name)
            elif isinstance(node, ast.Assign):
                found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
        assert name in found, f"docs/lecture.md names {place}, which is gone"
