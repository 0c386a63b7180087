"""The table: family, case, law, what was found, and the cost as a multiple of the plain scene's.

`python -m tests.stability [--markdown] [FAMILY ...]`; --markdown puts it into README.md and docs/stability.md.
"""

from __future__ import annotations

import os
import sys
import time
import traceback

from . import load_cases
from .lab import SIZE, Case, Finding
from .space import CACHE, reference
from .table import Row, rewrite


def run(item: Case) -> Finding:
    """The finding of a case; an exception is one."""
    try:
        return item.check()
    except Exception as error:
        traceback.print_exc()
        return Finding(False, f"{type(error).__name__}: {error}", 0.0)


def main(arguments: list[str]) -> int:
    """Run the cases of the families named, or all; 1 when a law is broken."""
    families = [word for word in arguments if word != "--markdown"]
    cases = [item for item in load_cases() if not families or item.family in families]
    if not cases or len({item.family for item in cases}) < len(set(families)):
        print(f"families: {', '.join(dict.fromkeys(item.family for item in load_cases()))}")
        return 2
    reference()  # compiles
    CACHE.clear()
    shot = reference()
    unit = shot.seconds / (len(shot.passes["Direct"]) * SIZE * SIZE)
    print(f"plain scene: {shot.seconds:.2f} s of one core for {len(shot.passes['Direct'])} passes\n")
    print("| family | case | law | found | cost |\n| --- | --- | --- | --- | --- |")
    rows: list[Row] = []
    begin = time.monotonic()
    for item in cases:
        found = run(item)
        rows.append(Row(item, found, found.seconds / (unit * 4 * SIZE * SIZE)))
        verdict = found.figure if found.good else f"**BROKEN** {item.known}: {found.figure}"
        print(f"| {item.family} | {item.name} | {item.law} | {verdict} | {rows[-1].cost:.1f}x |", flush=True)
    # a known fault that is gone must lose its mark
    broken = sum(row.found.good == bool(row.case.known) for row in rows)
    print(f"\n{len(cases)} cases, {broken} not as expected, {time.monotonic() - begin:.0f} s")
    if "--markdown" in arguments:
        rewrite(rows)
    return 1 if broken else 0


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)  # Blender as a module can hang while the interpreter shuts down
