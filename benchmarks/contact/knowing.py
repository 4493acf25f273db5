"""What knowing where the environment goes could gain at best: ``python -m benchmarks.contact.knowing [--cases N]``.

The rounded form as it is, and with the environment's true velocity added to what yields, in the moving sets and the
steady pulls of `benchmarks.contact.following`: from the instant at which it moves, from when its touch stands out from
errors, and from when the wrench is where yielding begins. No estimate can be better than knowing from the touch on.
Delay, lag and acceleration stay as they are.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.contact.adversary import YIELD_START
from benchmarks.contact.cases import Case
from benchmarks.contact.following import MOVING, case, numbers
from benchmarks.contact.laws import CaseLaw, make_law
from benchmarks.contact.robot import Robot
from benchmarks.contact.simulate import simulate
from services.controller.bounds.yielding import Yielding, YieldInput
from shared.spatial import Array

SETS = (*MOVING, "steady pull")
_STANDS_OUT = 3.0  # error bounds

Knows = Callable[[Case, Array], bool]
KNOWS: dict[str, Knows | None] = {
    "as it is": None,
    "at once": lambda case, wrench: True,
    "touched": lambda case, wrench: bool((np.abs(wrench) > _STANDS_OUT * case.error_bound).any()),
    "yielding": lambda case, wrench: bool((np.abs(wrench) > YIELD_START * (case.limit - case.error_bound)).any()),
}
"""From when on it knows, given the case and the measured wrench (6,) without the nominal one."""


def velocity(case: Case, time: float) -> Array:
    """The environment's velocity (3,) [m/s] at a time [s]."""
    leg = int(np.searchsorted(case.shift_times, time, side="right")) - 1
    if not 0 <= leg < len(case.shift_times) - 1:
        return np.zeros(3)
    return (case.shift[leg + 1] - case.shift[leg]) / (case.shift_times[leg + 1] - case.shift_times[leg])


class Knowing(CaseLaw):
    """The rounded form, told the environment's velocity as old as the sensor's samples."""

    def __init__(self, made: CaseLaw, knows: Knows) -> None:
        super().__init__(made.law, made.case)
        self._knows, self._known, self._velocity = knows, False, np.zeros(3)
        self._yielding: Yielding = vars(made.law)["_yielding"]
        self._own = self._yielding.step
        self._yielding.step = self._step  # type: ignore[method-assign]

    def twist(self, wrench: Array, robot: Robot, now: float, dt: float) -> Array:
        self._velocity = velocity(self.case, now - self.case.timing.latency)
        moves = bool(self._velocity.any())
        self._known = moves and (self._known or self._knows(self.case, wrench - self.case.nominal))
        self._yielding.moved = self._yielding.moved or self._known
        return super().twist(wrench, robot, now, dt)

    def _step(self, state: YieldInput) -> list[float] | None:
        own = self._own(state)
        if not self._known:
            return own
        self._yielding.moved = True
        return (np.array(own or [0.0] * 6) + np.r_[self._velocity, np.zeros(3)]).tolist()


def _peak(job: tuple[str, str, int]) -> float:
    how, group, number = job
    made, knows = make_law("certified-rounded", case(group, number)), KNOWS[how]
    return simulate(made if knows is None else Knowing(made, knows)).peak


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact.knowing", description=__doc__)
    parser.add_argument("--cases", type=int, default=40, help="of each random set (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default %(default)s)")
    given = parser.parse_args(arguments)
    every = [(group, number) for group in SETS for number in numbers(group, given.cases)]
    jobs = [(how, *one) for how in KNOWS for one in every]
    with ProcessPoolExecutor(given.jobs) as pool:
        peaks = dict(zip(jobs, pool.map(_peak, jobs, chunksize=4), strict=True))
    print(f"{'set':<15} {'knows':<9} {'cases':>5} {'p50':>6} {'p95':>6} {'max':>6}   times as it is")
    for group in SETS:
        before: Array | None = None
        for how in KNOWS:
            found = [peak for job, peak in peaks.items() if job[:2] == (how, group)]
            quantiles = np.quantile(found, (0.5, 0.95, 1.0))
            before = quantiles if before is None else before
            ratio = " ".join(f"{value:.2f}" for value in quantiles / before)
            print(f"{group:<15} {how:<9} {len(found):>5} " + " ".join(f"{v:>6.2f}" for v in quantiles) + f"   {ratio}")


if __name__ == "__main__":
    main()
