"""Random ticks of the controller, and the quadratic programs that they lead to."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import piqp

from services.controller.laws import make_law
from services.controller.laws.law import LawInput
from services.controller.laws.qp import Qp
from services.controller.parameters import ControllerParameters
from shared.spatial import Array, rotation_from_vector

PERIOD = 0.01
LIMIT = np.array((25.0, 25.0, 25.0, 3.0, 3.0, 3.0))
ERROR = np.array((0.3, 0.3, 0.3, 0.03, 0.03, 0.03))
NEW_TARGET = 100
"""Ticks between two targets."""


@dataclass(frozen=True)
class Problem:
    """``minimise x' diag(weight) x + cost' x  subject to  rows x <= right, lower <= x <= upper``; and PIQP's answer."""

    weight: Array
    cost: Array
    rows: Array
    right: Array
    lower: Array
    upper: Array
    answer: Array


Solve = Callable[[Problem], Array]


class Unsolved(Exception):
    """The solver gave no answer."""


@dataclass(frozen=True)
class Sample:
    """One tick: the times [us] of the whole tick and of nothing but PIQP on the same problem; the problem if kept."""

    tick: float
    bare: float
    problem: Problem | None


class Bare:
    """PIQP alone, with the controller's settings: update, solve, read the answer."""

    def __init__(self, qp: Qp) -> None:
        self._solver = qp.new_solver()

    def solve(self, qp: Qp) -> Array:
        """The minimiser of the problem whose data ``qp`` holds."""
        self._solver.update(c=qp.cost, G=qp.rows, h_u=qp.right, x_l=qp.lower, x_u=qp.upper)
        if self._solver.solve() != piqp.PIQP_SOLVED:
            raise RuntimeError("PIQP did not solve a problem that the controller had solved")
        return self._solver.result.x


def samples(count: int, parameters: ControllerParameters, keep: bool = False, seed: int = 0) -> list[Sample]:
    """Ticks of a tool that follows changing targets under a random wrench; each followed by the bare solve.

    The two are timed one after the other, so that whatever else the machine does falls on both alike. Keeping the
    problems is for a run that is not timed: megabytes of copies pass through the caches between the ticks.
    """
    rng = np.random.default_rng(seed)
    law = make_law(parameters)
    qp = law.qp
    bare = Bare(qp)
    found: list[Sample] = []
    position, rotation, wrench = np.zeros(3), np.eye(3), np.zeros(6)
    target, target_rotation = np.zeros(3), np.eye(3)
    tick = 0
    while len(found) < count:
        if tick % NEW_TARGET == 0:
            target, target_rotation = 0.3 * rng.normal(size=3), rotation_from_vector(0.5 * rng.normal(size=3))
        wrench = 0.97 * wrench + 0.03 * rng.normal(size=6) * LIMIT
        state = LawInput(wrench, LIMIT, ERROR, position, rotation, target, target_rotation)
        began = time.perf_counter_ns()
        output = law.step(state, PERIOD)
        between = time.perf_counter_ns()
        if output.failure is not None:
            raise RuntimeError(output.failure)
        again = time.perf_counter_ns()
        answer = bare.solve(qp)
        ended = time.perf_counter_ns()
        position = position + PERIOD * output.twist[:3]
        rotation = rotation_from_vector(PERIOD * output.twist[3:]) @ rotation
        tick += 1
        found.append(Sample((between - began) * 1e-3, (ended - again) * 1e-3, _problem(qp, answer) if keep else None))
    return found


def _problem(qp: Qp, answer: Array) -> Problem:
    parts = (qp.weight, qp.cost, qp.rows, qp.right, qp.lower, qp.upper, answer)
    return Problem(*(part.copy() for part in parts))
