"""The sweep: ``python -m benchmarks.carry [--harder] [--seeds FIRST-LAST] [--jobs N] [--kind KIND] [...]``."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from multiprocessing import get_context

from benchmarks.carry.cases import HARDER_KINDS, KINDS, Case, Changes, case
from benchmarks.carry.judge import Verdict, good_enough
from benchmarks.carry.play import play, verdict_of
from benchmarks.carry.report import line, show, trace
from shared.loop.config import service_assignment, value_of

SEEDS = "0-119"


def _all(seeds: Sequence[int], jobs: int, overrides: Changes, harder: bool) -> Iterator[tuple[Case, Verdict]]:
    # A process for each few cases: the physics engine's and the solver's memory is given back that way.
    with get_context("spawn").Pool(jobs, maxtasksperchild=8) as pool:
        yield from pool.imap_unordered(partial(verdict_of, overrides=overrides, harder=harder), seeds)


def main(arguments: Sequence[str] | None = None) -> int:
    """Play cases and print what became of them.

    Returns:
        0; 1 if a panel was dropped, torn out or let go of too early, or fewer than 99 % ended as they should.
    """
    parser = argparse.ArgumentParser(prog="python -m benchmarks.carry", description=__doc__)
    parser.add_argument("--seeds", default=SEEDS, help="first and last, FIRST-LAST, or some, N,N,...")
    parser.add_argument("--seed", type=int, help="one case only, with its states and reasons")
    parser.add_argument("--harder", action="store_true", help="people who are harder to carry with")
    parser.add_argument("--kind", choices=sorted({*KINDS, *HARDER_KINDS}), help="only cases of that kind")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes at a time")
    parser.add_argument(
        "--set", action="append", default=[], metavar="SERVICE.NAME=VALUE", help="a setting of all cases, value in TOML"
    )
    options = parser.parse_args(arguments)
    try:
        overrides = _settings(options.set)
    except ValueError as problem:
        parser.error(f"--set: {problem}")
    if options.seed is not None:
        played = play(case(options.seed, overrides, options.harder))
        trace(played)
        return 0 if played.verdict.as_it_should else 1
    seeds = [seed for seed in _numbers(options.seeds) if options.kind in (None, case(seed, harder=options.harder).kind)]
    begun, results = time.monotonic(), []
    try:
        for number, (chosen, verdict) in enumerate(_all(seeds, options.jobs, overrides, options.harder), 1):
            results.append((chosen, verdict))
            print(f"{number}/{len(seeds)} {line(chosen, verdict)}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print("broken off", file=sys.stderr)
    results.sort(key=lambda result: result[0].seed)
    if not results:
        return 1
    show(results, time.monotonic() - begun, options.jobs)
    return 0 if good_enough([verdict for _, verdict in results]) else 1


def _settings(given: Sequence[str]) -> Changes:
    found: Changes = {}
    for text in given:
        service, name, value = service_assignment(text)
        found.setdefault(service, {})[name] = value_of(value)
    return found


def _numbers(text: str) -> list[int]:
    if "," in text or "-" not in text:
        return [int(part) for part in text.split(",")]
    first, last = text.split("-")
    return list(range(int(first), int(last) + 1))


if __name__ == "__main__":
    sys.exit(main())
