"""``python -m benchmarks.contact``: the evidence for the guarantee, as a table, files, a figure and a verdict.

Exit status 1 when a required claim fails; the cases that break it are listed and can be repeated alone with
``--seed`` and ``--only set:number``.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import track

from benchmarks.contact import claims, figure, report
from benchmarks.contact.measure import SCRIPTED, Job, Row, plan, run_all, shuffled
from benchmarks.contact.sampling import GROUPS

_QUICK_CASES = 30
_CASES = 2000


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs what the options ask for; returns the exit status."""
    options = _options(arguments)
    console = Console(width=None if sys.stdout.isatty() else 180)
    began = time.monotonic()
    jobs = [_only(options.only, options.seed)] if options.only else shuffled(plan(options.seed, options.cases))
    rows: list[Row] = []
    try:
        for some in track(run_all(jobs, options.jobs), "contacts", len(jobs), console=Console(stderr=True)):
            rows += some
    except KeyboardInterrupt:
        console.print("stopped; what follows is about the cases run so far, an even sample of all sets")
    rows.sort(key=lambda row: (list((*GROUPS, *SCRIPTED)).index(row.job.group), row.job.number))
    summaries = report.summarise(rows)
    report.print_summaries(console, summaries)
    if options.only:
        return 0
    judged = claims.from_rows(rows) + claims.walls() + claims.approaches()
    report.print_claims(console, judged)
    facts = {
        "command": f"python -m benchmarks.contact --seed {options.seed} --cases {options.cases}",
        "seconds": round(time.monotonic() - began, 1),
        "cases": len({row.job for row in rows}),
    }
    report.write(options.out, rows, summaries, judged, facts)
    figure.draw(rows, options.out / "contact.png")
    failed = sum(not claim.passed for claim in judged)
    console.print(f"{facts['cases']} cases, {len(rows)} runs in {facts['seconds']} s, kept in {options.out}/")
    console.print(f"{len(judged) - failed} of {len(judged)} claims hold")
    return 1 if failed else 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact", description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"{_QUICK_CASES} random cases: a minute, for every change")
    parser.add_argument("--cases", type=int, default=None, help=f"random cases over all sets (default {_CASES})")
    parser.add_argument("--seed", type=int, default=0, help="what the random cases are drawn from (default 0)")
    parser.add_argument("--only", metavar="SET:NUMBER", help="one case alone, to look into")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--out", type=Path, default=Path("runs/contact"), help="folder (default runs/contact)")
    options = parser.parse_args(arguments)
    options.cases = options.cases or (_QUICK_CASES if options.quick else _CASES)
    return options


def _only(text: str, seed: int) -> Job:
    group, _, number = text.rpartition(":")
    if group not in (*GROUPS, *SCRIPTED) or not number.isdigit():
        names = ", ".join((*GROUPS, *SCRIPTED))
        raise SystemExit(f"--only wants SET:NUMBER with SET one of {names}; given {text!r}")
    return Job(seed, group, int(number))


if __name__ == "__main__":
    sys.exit(main())
