"""The benchmarks of speed as one table: ``python -m benchmarks [--quick] [--strict] [name ...]``.

What judges safety (`benchmarks.carry`, `benchmarks.contact`, `benchmarks.faults`) is a command of its own each.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence

from benchmarks.table import Row, missed, show

NAMES = ("solvers", "sim_speed", "load_speed", "chain", "startup", "bridges")
"""Modules of this package in the order of the table; each offers ``rows(quick: bool) -> list[Row]``."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmarks one after the other, so that none disturbs another, and print the table.

    Returns:
        0; with ``--strict`` 1 if a target was missed.
    """
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="name", help=f"only these of {', '.join(NAMES)}")
    parser.add_argument("--quick", action="store_true", help="fewer samples: a look, not a measurement")
    parser.add_argument("--strict", action="store_true", help="exit status 1 if a target was missed")
    options = parser.parse_args(arguments)
    if unknown := sorted(set(options.names) - set(NAMES)):
        parser.error(f"no benchmark {', '.join(unknown)}; there are {', '.join(NAMES)}")
    rows: list[Row] = []
    for name in options.names or NAMES:
        print(f"measuring {name} ...", file=sys.stderr, flush=True)
        rows += importlib.import_module(f"benchmarks.{name}").rows(options.quick)
    show(rows)
    if failures := missed(rows):
        print(f"{len(failures)} of {len(rows)} targets missed: {'; '.join(row.claim for row in failures)}")
    return 1 if options.strict and failures else 0


if __name__ == "__main__":
    sys.exit(main())
