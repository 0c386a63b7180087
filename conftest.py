"""Imports tests under the names that Python would use (photon_engine.bsdf.tests.test_x), and ends without hanging.

The root folder holds an __init__.py, since it is a Blender extension. Left alone, pytest would take the root for a
package and import modules a second time as <folder>.photon_engine..., with second copies of all types and kernels.
"""

import importlib
import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent
STATUS = pytest.StashKey[int]()

if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))


class RootedModule(pytest.Module):
    """A test file imported by its dotted name as seen from the root."""

    def _getobj(self):
        module = importlib.import_module(".".join(self.path.relative_to(ROOT).with_suffix("").parts))
        self.config.pluginmanager.consider_module(module)
        return module


def pytest_pycollect_makemodule(module_path, parent):
    return RootedModule.from_parent(parent, path=module_path)


def pytest_collect_directory(path, parent):
    return pytest.Dir.from_parent(parent, path=path)  # never a pytest.Package, which would import its __init__.py


def pytest_sessionfinish(session, exitstatus):
    session.config.stash[STATUS] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Blender as a module can hang while the interpreter shuts down (seen with bpy 4.5)."""
    if "bpy" in sys.modules and STATUS in config.stash:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.stash[STATUS])
