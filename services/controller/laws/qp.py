"""The quadratic program of a tick, solved by PIQP and checked outside of it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import piqp

from shared.spatial import Array

UNBOUNDED = 1e30
"""PIQP's infinity; finite, so that one sum over all data finds every non-finite number."""
TOLERANCE = 1e-6
"""Largest violation [m/s, rad/s] of a row or bound that is taken for rounding."""
CLOSED = 1e-7
"""Room [m/s, rad/s] below which a variable is fixed: in a thinner gap the solver's iterations multiply."""
_SOLVED = piqp.PIQP_SOLVED
MOST_ITERATIONS = 60
"""The problems need 8 to 20."""

Timer = Callable[[], int]


def no_timer() -> int:
    """A timer for whoever does not measure."""
    return 0


class QpFailure(Exception):
    """The quadratic program has no answer that can be trusted.

    Attributes:
        reason: what failed, one line.
        problem: copies of all data and of the answer, to solve it again elsewhere.
    """

    def __init__(self, reason: str, problem: dict[str, list]) -> None:
        super().__init__(reason)
        self.reason = reason
        self.problem = problem


class Qp:
    """``minimise x' diag(weight) x + cost' x  subject to  rows x <= right, lower <= x <= upper``.

    The data are arrays that the owner writes in place before each ``solve``; PIQP takes NaN for "no bound" and still
    reports success, so nothing reaches it unchecked, and its answer is held against the constraints.

    Args:
        weight: (n,) diagonal of the quadratic cost, fixed.
        rows: number m of general rows.
        timer: steady nanoseconds, for ``solve_us`` only.
        time_limit: [s] after which an answer is too old to be used.
    """

    def __init__(self, weight: Array, rows: int, timer: Timer = no_timer, time_limit: float = math.inf) -> None:
        n, m = len(weight), rows
        self._data = np.zeros(n + 2 * n + m * n + m)
        self.cost, self.lower, self.upper, flat = np.split(self._data, (n, 2 * n, 3 * n))
        # The right-hand side is one column more of the rows: both are held against [x; -1] at once.
        self._rows_and_right = flat.reshape((m, n + 1), order="F")
        self.rows, self.right = self._rows_and_right[:, :n], self._rows_and_right[:, n]
        self._answer = np.full(n + 1, -1.0)
        self._inside = self._answer[:n]
        self.upper[:] = UNBOUNDED
        self.time_limit = time_limit
        self.solve_us = 0.0
        self._timer = timer
        self.weight = weight
        self._quadratic = np.asfortranarray(np.diag(2.0 * np.asarray(weight)))
        self._unbounded_below = np.full(m, -UNBOUNDED)
        self.excess = np.zeros(m)
        self.largest_excess = 0.0
        self._solver = self.new_solver()

    def new_solver(self) -> piqp.DenseSolver:
        """A solver set up with the present data and the settings that are used here."""
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = 1e-9
        solver.settings.eps_rel = 0.0
        # The twist is as exact as the root of the duality gap: 1e-6 m/s, or a resting tool would creep.
        solver.settings.eps_duality_gap_abs = 1e-12
        solver.settings.eps_duality_gap_rel = 1e-12
        solver.settings.max_iter = MOST_ITERATIONS
        solver.setup(
            self._quadratic, self.cost, None, None, self.rows, self._unbounded_below, self.right, self.lower, self.upper
        )
        return solver

    def solve(self) -> Array:
        """The minimiser (n,), exactly within the bounds, in an array of this object's.

        ``excess`` (m,) is ``rows x - right``, ``largest_excess`` its largest element.

        Raises:
            QpFailure: non-finite data, not solved, too slow, or an answer that breaks a constraint.
        """
        data = self._data
        if not math.isfinite(data.dot(data)):
            raise self._failure("its data are not finite")
        began = self._timer()
        status, x = self._minimise()
        elapsed = (self._timer() - began) * 1e-9
        self.solve_us = elapsed * 1e6
        if status != _SOLVED:
            raise self._failure(f"the solver stopped with {getattr(status, 'name', status)}", x)
        if elapsed > self.time_limit:
            raise self._failure(f"it took {elapsed * 1e3:.1f} ms, allowed are {self.time_limit * 1e3:.1f} ms", x)
        inside = self._inside
        np.minimum(np.maximum(x, self.lower), self.upper, out=inside)
        self._rows_and_right.dot(self._answer, self.excess)
        self.largest_excess = max(self.excess.tolist())
        outside = inside - x
        distance = math.sqrt(outside.dot(outside))
        if not distance < math.inf:  # what is not a number is the same distance from itself
            raise self._failure("the solver's answer is not finite", x)
        if self.largest_excess > TOLERANCE or distance > TOLERANCE:
            worst = max(self.largest_excess, distance)
            raise self._failure(f"the solver's answer breaks a constraint by {worst:.1e}", x)
        return inside

    def _minimise(self) -> tuple[piqp.Status, Array]:
        self._solver.update(c=self.cost, G=self.rows, h_u=self.right, x_l=self.lower, x_u=self.upper)
        status = self._solver.solve()
        return status, self._solver.result.x

    def _failure(self, reason: str, x: Array | None = None) -> QpFailure:
        # Whatever the solver keeps from a bad problem must not reach the next one.
        problem = {name: getattr(self, name).tolist() for name in ("cost", "right", "lower", "upper", "rows")}
        problem["answer"] = [] if x is None else x.tolist()
        self._solver = self.new_solver()
        return QpFailure(f"quadratic program: {reason}", problem)
