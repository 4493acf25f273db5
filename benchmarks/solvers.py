"""The controller's tick against the bare solve and other solvers: ``python -m benchmarks.solvers [--quick]``.

``--against REV`` measures nothing but the tick, in turns with another revision's.
"""

from __future__ import annotations

import argparse
import gc
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import against
from benchmarks.solver_problems import Problem, Sample, Solve, Unsolved, samples
from benchmarks.table import Row, at_least, at_most, show, shown
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

COMMAND = "python -m benchmarks.solvers"
PROBLEMS = 5000
QUICK = 500
WARM_UP = 200
FORMS = {"strict": 1.0, "rounded": 0.8}
TICKS = """
import gc, json
import numpy as np
from benchmarks.solver_problems import samples
from services.controller.parameters import ControllerParameters

found = {}
for form, yield_start in (("strict", 1.0), ("rounded", 0.8)):
    zone = {"stiffness": 2000.0, "reach": (0.1, 0.1, 0.05)}
    settings = {"yield_start": yield_start, "contact_reach": (0.5, 0.3, 0.1), "zones": [zone]}
    gc.collect()
    gc.disable()
    ticks = samples(4200, ControllerParameters.of(settings))[200:]
    gc.enable()
    tick, bare = np.array([tick.tick for tick in ticks]), np.array([tick.bare for tick in ticks])
    found |= {f"tick, {form}, p10 [us]": np.percentile(tick, 10), f"tick, {form}, p50 [us]": np.median(tick)}
    found[f"bare PIQP, {form}, p10 [us]"] = np.percentile(bare, 10)
print(json.dumps(found))
"""
"""What is measured of another revision; the bare solve is the same in both and shows how far to trust the rest."""


@dataclass(frozen=True)
class Timing:
    """Times [us] of one contestant; difference of its twists to the controller's [m/s, rad/s]; problems not solved."""

    name: str
    times: Array
    differences: Array
    unsolved: int = 0

    @property
    def median(self) -> float:
        """50th percentile [us]."""
        return float(np.percentile(self.times, 50))

    @property
    def slow(self) -> float:
        """99th percentile [us]."""
        return float(np.percentile(self.times, 99))


def parameters(yield_start: float) -> ControllerParameters:
    """A person's arms on a panel and a hard contact near the tool: both kinds of zones."""
    return ControllerParameters.of(
        {
            "yield_start": yield_start,
            "contact_reach": (0.5, 0.3, 0.1),
            "zones": [{"stiffness": 2000.0, "reach": (0.1, 0.1, 0.05)}],
        }
    )


def measure(count: int, yield_start: float) -> list[Sample]:
    """Timed ticks without the first ones, which fill caches, and without the garbage collector."""
    gc.collect()
    gc.disable()
    try:
        return samples(count + WARM_UP, parameters(yield_start))[WARM_UP:]
    finally:
        gc.enable()


def contest(name: str, solve: Solve, problems: list[Problem]) -> Timing:
    """One peer on all problems."""
    times, differences, unsolved = [], [], 0
    for problem in problems:
        began = time.perf_counter_ns()
        try:
            answer = solve(problem)
        except Unsolved:
            unsolved += 1
            answer = None
        times.append((time.perf_counter_ns() - began) * 1e-3)
        if answer is not None:
            differences.append(float(np.abs(twist(answer) - twist(problem.answer)).max()))
    return Timing(name, np.array(times), np.array(differences), unsolved)


def twist(answer: Array) -> Array:
    """``p - q`` (6,) of an answer (13,)."""
    return answer[6:12] - answer[:6]


def timings(count: int) -> tuple[dict[str, tuple[Timing, Timing]], list[Timing]]:
    """Per form the tick and the bare solve; then the peers on the strict form's problems."""
    # Only here: to compare revisions takes no other solver.
    from benchmarks.solver_peers import peers, silent

    own: dict[str, tuple[Timing, Timing]] = {}
    for form, yield_start in FORMS.items():
        found = measure(count, yield_start)
        none = np.zeros(1)
        own[form] = (
            Timing(f"tick, {form}", np.array([sample.tick for sample in found]), none),
            Timing(f"bare PIQP, {form}", np.array([sample.bare for sample in found]), none),
        )
    kept = samples(count + WARM_UP, parameters(FORMS["strict"]), keep=True)[WARM_UP:]
    problems = [sample.problem for sample in kept if sample.problem is not None]
    with silent():
        return own, [contest(name, solve, problems) for name, solve in peers(problems[0]).items()]


def rows(quick: bool) -> list[Row]:
    """The claims about the controller's tick, for the table of all benchmarks."""
    own, others = timings(QUICK if quick else PROBLEMS)
    Console(stderr=True).print(_table(own, others))
    found = []
    for form, (tick, bare) in own.items():
        ratio = tick.median / bare.median
        note = f"{tick.median:.0f} against {bare.median:.0f} us"
        found.append(at_most(f"controller's tick over bare PIQP, {form}, p50", ratio, 2.0, "", COMMAND, note))
        found.append(at_most(f"controller's tick, {form}, p99", tick.slow, 200.0, "us", COMMAND))
    tick, _ = own["strict"]
    for peer in others:
        ratio = peer.median / tick.median
        note = f"{peer.median:.0f} us, {peer.unsolved} of {len(peer.times)} unsolved"
        claim = f"{peer.name} over the controller's tick, p50"
        found.append(
            at_least(claim, ratio, 20.0, "", COMMAND, note)
            if "IPOPT" in peer.name
            else shown(claim, ratio, "", COMMAND, note)
        )
        agreement = float(peer.differences.max()) if len(peer.differences) else np.nan
        found.append(shown(f"largest difference of the twist, {peer.name}", agreement * 1e6, "um/s", COMMAND))
    return found


def _table(own: dict[str, tuple[Timing, Timing]], others: list[Timing]) -> Table:
    table = Table(title="one tick on the same random problems")
    for column in ("", "p50 [us]", "p99 [us]", "over the tick", "largest difference [um/s]", "unsolved"):
        table.add_column(column, justify="left" if not column else "right")
    reference = own["strict"][0].median
    for timing in [*(timing for pair in own.values() for timing in pair), *others]:
        agreement = f"{timing.differences.max() * 1e6:.2g}" if len(timing.differences) else "none"
        table.add_row(
            timing.name,
            f"{timing.median:.0f}",
            f"{timing.slow:.0f}",
            f"{timing.median / reference:.2f}",
            agreement,
            str(timing.unsolved),
        )
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the comparison and the claims."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer samples: a look, not a measurement")
    parser.add_argument("--against", metavar="REV", help="a revision of git, such as HEAD")
    given = parser.parse_args(arguments)
    if given.against:
        against.show(against.compare(given.against, TICKS))
    else:
        show(rows(given.quick))


if __name__ == "__main__":
    main()
