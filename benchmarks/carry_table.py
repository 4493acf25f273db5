"""The carry under each law in simulated time, as tables: ``python -m benchmarks.carry_table [RUN ...]``.

Nothing in it depends on the machine, so that anybody gets the figures of docs/experiment.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks.experiment_stack import play_run
from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_measures import measure
from services.experiment.carry.carry_tables import notes, tables
from services.experiment.measure.claim import Table

RUNS = ("certified-omni", "certified-differential", "certified-none", "paper-omni", "stiffness-omni")


def markdown(table: Table) -> str:
    """A table as the documents have it, under its title."""
    rows = (table.head, ("---",) * len(table.head), *table.rows)
    return "\n".join((f"{table.title}:", "", *(f"| {' | '.join(row)} |" for row in rows), ""))


def main(arguments: Sequence[str] | None = None) -> int:
    """Play the runs one after the other, and print what was found.

    Returns:
        0.
    """
    parser = argparse.ArgumentParser(prog="python -m benchmarks.carry_table", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="RUN", help=f"LAW-BASE; default: {' '.join(RUNS)}")
    options = parser.parse_args(arguments)
    try:
        runs = [CARRY.run_named(name) for name in options.names or RUNS]
    except ValueError as problem:
        parser.error(str(problem))
    measured = {}
    for run in runs:
        print(f"playing {run.name} ...", file=sys.stderr, flush=True)
        measured[run.name] = measure(play_run(CARRY, run))
    for table in tables(measured):
        print(markdown(table))
    for note in notes(measured):
        print(f"- {note}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
