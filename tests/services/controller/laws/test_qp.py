"""The quadratic program: right answers, and every way in which it must not be believed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import piqp
import pytest

from services.controller.laws.qp import Qp, QpFailure
from shared.spatial import Array


class LyingQp(Qp):
    """A solver whose answer is made up."""

    status = piqp.PIQP_SOLVED
    lie: Callable[[Array], Array] | None = None

    def _minimise(self) -> tuple[piqp.Status, Array]:
        _, x = super()._minimise()
        return self.status, x if self.lie is None else self.lie(x)


def problem(kind: type[Qp] = Qp, **settings: object) -> Qp:
    """``min x^2 + y^2 - 2x - 4y  with  x + y <= 1, 0 <= x, y <= 0.8``: x = 0.2, y = 0.8."""
    qp = kind(np.ones(2), 1, **settings)
    qp.cost[:] = (-2.0, -4.0)
    qp.rows[0] = (1.0, 1.0)
    qp.right[0] = 1.0
    qp.upper[:] = 0.8
    return qp


def test_minimiser() -> None:
    assert problem().solve() == pytest.approx([0.2, 0.8], abs=1e-7)


@pytest.mark.parametrize("name", ["cost", "rows", "right", "lower", "upper"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_data_that_are_not_finite_never_reach_the_solver(name: str, value: float) -> None:
    qp = problem(LyingQp)
    qp.lie = lambda x: pytest.fail("the solver was called")
    getattr(qp, name)[..., 0] = value
    with pytest.raises(QpFailure, match="not finite") as failure:
        qp.solve()
    assert len(failure.value.problem["upper"]) == 2


LIES = {
    "not a number": (lambda x: x * math.nan, "answer is not finite"),
    "infinite": (lambda x: x * math.inf, "answer is not finite"),
    "beyond a row": (lambda x: np.array((0.7, 0.7)), "breaks a constraint by 4.0e-01"),
    "beyond an upper bound": (lambda x: np.array((0.0, 0.9)), "breaks a constraint by 1.0e-01"),
    "beyond a lower bound": (lambda x: np.array((-0.1, 0.1)), "breaks a constraint by 1.0e-01"),
}


@pytest.mark.parametrize("lie", LIES)
def test_wrong_answers_are_found_out_and_the_next_problem_is_solved(lie: str) -> None:
    qp = problem(LyingQp)
    qp.lie, text = LIES[lie]
    with pytest.raises(QpFailure, match=text) as failure:
        qp.solve()
    assert failure.value.problem["answer"]
    qp.lie = None
    assert qp.solve() == pytest.approx([0.2, 0.8], abs=1e-7)


def test_unsolved_is_a_failure() -> None:
    qp = problem(LyingQp)
    qp.status = piqp.PIQP_MAX_ITER_REACHED
    with pytest.raises(QpFailure, match="MAX_ITER"):
        qp.solve()


def test_infeasible_is_a_failure_within_bounded_iterations() -> None:
    qp = problem()
    qp.right[0] = -1.0
    with pytest.raises(QpFailure, match="stopped with"):
        qp.solve()


def test_an_answer_that_took_too_long_is_not_used() -> None:
    times = iter((0, 30_000_000))
    qp = problem(timer=lambda: next(times), time_limit=0.02)
    with pytest.raises(QpFailure, match=r"30\.0 ms, allowed are 20\.0 ms"):
        qp.solve()
    assert qp.solve_us == pytest.approx(30_000)


def test_bad_data_leave_no_trace() -> None:
    qp = problem()
    for _ in range(50):
        qp.cost[0] = math.nan
        with pytest.raises(QpFailure):
            qp.solve()
        qp.cost[0] = -2.0
        assert qp.solve() == pytest.approx([0.2, 0.8], abs=1e-7)
