"""Other solvers behind one call: a problem in, its minimiser out."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import casadi
import daqp
import numpy as np
import quadprog

from benchmarks.solver_problems import Problem, Solve, Unsolved
from services.controller.laws.qp import UNBOUNDED
from shared.spatial import Array

REGULARISED = 1e-9
"""Quadratic weight of gamma for solvers that need a positive definite cost; the controller's has none."""


def peers(problem: Problem) -> dict[str, Solve]:
    """The peers, set up for problems of this size."""
    return {
        "CasADi + IPOPT": _ipopt(problem),
        "CasADi + qpOASES": _qpoases(problem),
        "quadprog": _quadprog,
        "DAQP": _daqp,
    }


def _parametric(problem: Problem) -> tuple[dict[str, Any], Callable[[Problem], Array]]:
    """The problem with its data as CasADi parameters, built once as a user of CasADi would."""
    m, n = problem.rows.shape
    x, cost, rows = casadi.SX.sym("x", n), casadi.SX.sym("c", n), casadi.SX.sym("G", m, n)
    parameters = casadi.vertcat(cost, casadi.vec(rows))
    objective = casadi.sum1(casadi.DM(problem.weight) * x**2) + casadi.dot(cost, x)
    symbolic = {"x": x, "p": parameters, "f": objective, "g": rows @ x}
    return symbolic, lambda data: np.concatenate((data.cost, data.rows.ravel(order="F")))


def _casadi(function: casadi.Function, values: Callable[[Problem], Array]) -> Solve:
    def solve(problem: Problem) -> Array:
        upper = np.where(problem.upper >= UNBOUNDED, np.inf, problem.upper)
        answer = function(p=values(problem), lbx=problem.lower, ubx=upper, lbg=-np.inf, ubg=problem.right, x0=0.0)
        if not function.stats()["success"]:
            raise Unsolved
        return answer["x"].full().ravel()

    return solve


def _ipopt(problem: Problem) -> Solve:
    symbolic, values = _parametric(problem)
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}}
    return _casadi(casadi.nlpsol("ipopt", "ipopt", symbolic, quiet), values)


@contextmanager
def silent() -> Iterator[None]:
    """Standard output closed at the system's level: qpOASES prints its licence for every problem."""
    sys.stdout.flush()
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)


def _qpoases(problem: Problem) -> Solve:
    symbolic, values = _parametric(problem)
    quiet = {"print_time": False, "printLevel": "none", "error_on_fail": False}
    return _casadi(casadi.qpsol("qpoases", "qpoases", symbolic, quiet), values)


def _quadprog(problem: Problem) -> Array:
    n = len(problem.cost)
    cost = np.diag(2.0 * (problem.weight + REGULARISED * (problem.weight == 0.0)))
    bounded = problem.upper < UNBOUNDED
    identity = np.eye(n)
    left = np.vstack((-problem.rows, identity, -identity[bounded]))
    right = np.concatenate((-problem.right, problem.lower, -problem.upper[bounded]))
    try:
        return quadprog.solve_qp(cost, -problem.cost, left.T, right)[0]
    except ValueError as unsolved:
        raise Unsolved from unsolved


def _daqp(problem: Problem) -> Array:
    cost = np.diag(2.0 * (problem.weight + REGULARISED * (problem.weight == 0.0)))
    upper = np.concatenate((problem.upper, problem.right))
    lower = np.concatenate((problem.lower, np.full(len(problem.right), -UNBOUNDED)))
    answer, _, status, _ = daqp.solve(cost, problem.cost, np.ascontiguousarray(problem.rows), upper, lower)
    if status != 1:
        raise Unsolved
    return np.array(answer)
