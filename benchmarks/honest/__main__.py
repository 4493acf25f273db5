"""``python -m benchmarks.honest``: how often something false is stated of 2,000 sensors and cameras.

A sample of `wrench/external` that is valid is false if it is farther from the truth than 1.05 times its own bound; a
marker that the task goes to is false if it is off by more than 1 cm or 2 degrees. Exit status 1 if a target is missed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

from rich.console import Console
from rich.progress import track

from benchmarks.honest import report
from benchmarks.honest.draws import KINDS, Draw, plan, play_all
from benchmarks.table import missed, show

COMMAND = "python -m benchmarks.honest"
_DRAWS, _QUICK = 2000, 120


def main(arguments: Sequence[str] | None = None) -> int:
    """Plays what the options ask for; returns the exit status."""
    options = _options(arguments)
    console = Console(width=None if sys.stdout.isatty() else 160)
    began = time.monotonic()
    draws = [_only(options.only, options.seed)] if options.only else plan(options.seed, options.draws)
    played = track(play_all(draws, options.jobs), "draws", len(draws), console=Console(stderr=True))
    verdicts = sorted(played, key=lambda verdict: (list(KINDS).index(verdict.kind), verdict.seed))
    report.print_table(console, verdicts)
    report.print_cases(console, verdicts)
    console.print(f"{len(draws)} draws in {time.monotonic() - began:.0f} s; each again: {COMMAND} --only KIND:NUMBER")
    if options.only:
        return 0
    rows = report.rows(verdicts, f"{COMMAND} --seed {options.seed} --draws {options.draws}")
    show(rows)
    return 1 if missed(rows) else 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"{_QUICK} draws: half a minute, for every change")
    parser.add_argument("--draws", type=int, default=None, help=f"how many (default {_DRAWS})")
    parser.add_argument("--seed", type=int, default=0, help="what they are drawn from (default 0)")
    parser.add_argument("--only", metavar="KIND:NUMBER", help="one draw alone, to look into")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    options = parser.parse_args(arguments)
    options.draws = options.draws or (_QUICK if options.quick else _DRAWS)
    return options


def _only(text: str, seed: int) -> Draw:
    kind, _, number = text.rpartition(":")
    if kind not in KINDS or not number.isdigit():
        raise SystemExit(f"--only wants KIND:NUMBER with KIND one of {', '.join(KINDS)}; given {text!r}")
    return Draw(seed, kind, int(number))


if __name__ == "__main__":
    sys.exit(main())
