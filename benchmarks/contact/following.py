"""How the law follows an environment that moves: ``python -m benchmarks.contact.following [--against REV]``.

The random sets that move and the steady pulls, all at 100 Hz, and a contact shaken to and fro at 1 to 5 Hz: peaks in
limits under the rounded form and under the paper's law. Every case is a function of its number, so two revisions meet
the same ones; this file runs in both trees, and uses nothing that only one of them has.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import count, islice
from pathlib import Path

import numpy as np

from benchmarks.contact.cases import Case, Target
from benchmarks.contact.elastic import Spring
from benchmarks.contact.laws import make_law
from benchmarks.contact.sampling import draw
from benchmarks.contact.scripted import declared, steady_pull, still, timing
from benchmarks.contact.simulate import simulate
from benchmarks.contact.world import Contact
from shared.spatial import Array

RATE = 100.0
MOVING = ("moving-0.1", "moving-0.2", "moving-0.1-far", "moving-0.2-far")
SHAKEN = {"shaken-1": 1.0, "shaken-2": 2.0, "shaken-3": 3.0, "shaken-5": 5.0}
"""By name of the set: how often a second [Hz]."""
SETS = (*MOVING, "steady pull", *SHAKEN)
LAWS = ("certified-rounded", "paper")
PULLS = 108
"""Steady pulls, of which a third runs at 100 Hz."""
_CASES = 40
_SHARES = (1.0, 0.5, 0.2)
"""Of the declared stiffness that a shaken contact has."""
_FASTEST = 0.2  # [m/s], of a hand that shakes
_STIFFNESS, _LIMIT = 1000.0, np.repeat((10.0, 3.0), 3)
_SHAKES_FOR = 2.0

Found = dict[str, dict[str, list[float]]]
"""By law and set: the peaks [limits], and last how many runs go on swinging."""


def shaken(group: str, number: int) -> Case:
    """A spring at the tool's origin whose other end goes to and fro for 2 s, at most at 0.2 m/s, and then rests."""
    origin = np.zeros(3)
    spring = Contact(origin, True, Spring(_SHARES[number] * _STIFFNESS * np.eye(3), origin))
    rested = still(group, (spring,), _LIMIT, (Target(0.0, origin, np.eye(3)),), _SHAKES_FOR + 1.4)
    times = np.linspace(0.0, _SHAKES_FOR, 401)
    rate = 2.0 * math.pi * SHAKEN[group]
    way: Array = np.outer(_FASTEST / rate * np.sin(rate * times), (1.0, 0.0, 0.0))
    return replace(
        rested,
        timing=timing(1.0 / RATE, delay=0.03, lag=0.02),
        declared=declared(_STIFFNESS, (0.05, 0.05, 0.05), weight=1.0),
        shift_times=times,
        shift=way,
    )


def case(group: str, number: int) -> Case:
    """Case ``number`` of a set."""
    if group in SHAKEN:
        return shaken(group, number)
    return steady_pull(number) if group == "steady pull" else draw(0, group, number)


def numbers(group: str, cases: int) -> Iterator[int]:
    """Those of the set's cases that run at 100 Hz: of the random ones the first ``cases``, of the scripted ones all."""
    if group in MOVING:
        every: Iterator[int] = count()
    else:
        every, cases = iter(range(len(_SHARES) if group in SHAKEN else PULLS)), PULLS
    return islice((number for number in every if math.isclose(case(group, number).timing.period, 1.0 / RATE)), cases)


def _run(job: tuple[str, str, int]) -> tuple[float, bool]:
    law, group, number = job
    result = simulate(make_law(law, case(group, number)))
    return result.peak, result.sustained


def measure(cases: int, processes: int) -> Found:
    """The peaks of all laws in all sets, in the tree that this runs in."""
    jobs = [(law, group, number) for law in LAWS for group in SETS for number in numbers(group, cases)]
    found: Found = {law: {group: [] for group in SETS} for law in LAWS}
    swings = {(law, group): 0 for law in LAWS for group in SETS}
    with ProcessPoolExecutor(processes) as pool:
        for (law, group, _), (peak, sustained) in zip(jobs, pool.map(_run, jobs, chunksize=4), strict=True):
            found[law][group].append(peak)
            swings[law, group] += sustained
    for (law, group), number in swings.items():
        found[law][group].append(number)
    return found


def _elsewhere(revision: str, options: Sequence[str]) -> Found:
    """The same in another revision's tree."""
    from tests.support.revision import worktree

    with worktree(revision) as folder:
        # Without a file the first place where Python looks for modules is the current folder: the tree's.
        command = [sys.executable, "-c", Path(__file__).read_text(), "--json", *options]
        return json.loads(subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, check=True, text=True).stdout)


def show(found: Found, before: Found | None = None) -> None:
    """Print a line per set and law; with the figures of ``before``, and the ratio to them, for the first law."""
    titles = f"{'set':<15} {'law':<18} {'cases':>5} {'p50':>6} {'p95':>6} {'max':>6} swing"
    print(titles + ("   before: p95, max" if before else ""))
    for group in SETS:
        for law in LAWS:
            *peaks, swings = found[law][group]
            middle, high, most = np.quantile(peaks, (0.5, 0.95, 1.0))
            line = f"{group:<15} {law:<18} {len(peaks):>5} {middle:>6.2f} {high:>6.2f} {most:>6.2f} {swings:>5.0f}"
            if before and law == LAWS[0]:
                was_high, was_most = np.quantile(before[law][group][:-1], (0.95, 1.0))
                line += f"   {was_high:.2f}, {was_most:.2f}: {high / was_high:.2f} and {most / was_most:.2f} times"
            print(line)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact.following", description=__doc__)
    parser.add_argument("--against", metavar="REV", help="compare with another revision of git, such as HEAD~1")
    parser.add_argument("--cases", type=int, default=_CASES, help="of each random set (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default %(default)s)")
    parser.add_argument("--json", action="store_true", help="all peaks, for programs")
    given = parser.parse_args(arguments)
    found = measure(given.cases, given.jobs)
    if given.json:
        print(json.dumps(found))
        return
    options = ["--cases", str(given.cases), "--jobs", str(given.jobs)]
    show(found, _elsewhere(given.against, options) if given.against else None)


if __name__ == "__main__":
    main()
