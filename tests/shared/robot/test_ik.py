"""Differential inverse kinematics: bounds kept, direction kept, and the closed form against the quadratic program."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.sim.robot.kinematics import arm_kinematics
from shared.robot import ik as module
from shared.robot.ik import DifferentialIK
from shared.robot.tiago import CHAIN

KINEMATICS = arm_kinematics()
WEIGHT = np.array([10.0] + [1.0] * 7)
MARGIN = np.full(8, 0.01)
REST = np.zeros(8)
ROUNDING = 1e-6

shares = st.lists(st.floats(0.0, 1.0), min_size=8, max_size=8).map(np.array)
twists = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(np.array)


def solver() -> DifferentialIK:
    return DifferentialIK(KINEMATICS.lower, KINEMATICS.upper, KINEMATICS.speed, MARGIN, CHAIN, WEIGHT)


def at(position: np.ndarray) -> np.ndarray:
    KINEMATICS.update(position)
    return KINEMATICS.jacobian()


@settings(max_examples=200, deadline=None)
@given(share=shares, twist=twists, towards=shares)
def test_speed_limits_are_kept_and_the_twist_is_only_scaled(
    share: np.ndarray, twist: np.ndarray, towards: np.ndarray
) -> None:
    span = KINEMATICS.upper - KINEMATICS.lower
    position = KINEMATICS.lower + share * span
    jacobian = at(position)
    solution = solver().solve(position, jacobian, twist, KINEMATICS.lower + towards * span, REST)
    lowest, highest = solver().bounds(position)
    assert (solution.velocity >= lowest).all() and (solution.velocity <= highest).all()
    assert (np.abs(solution.velocity) <= KINEMATICS.speed).all()
    assert 0.0 <= solution.share <= 1.0
    size = np.linalg.norm(twist)
    assert jacobian @ solution.velocity == pytest.approx(solution.share * twist, abs=1e-4 * size + ROUNDING)
    assert (solution.limited_by != "") == (solution.share <= 0.999)


@settings(max_examples=100, deadline=None)
@given(share=shares, twist=twists)
def test_no_joint_is_driven_beyond_its_limit(share: np.ndarray, twist: np.ndarray) -> None:
    inside = 2 * MARGIN
    low, high = KINEMATICS.lower + inside, KINEMATICS.upper - inside
    position = low + share * (high - low)
    inverse = solver()
    for _ in range(100):
        solution = inverse.solve(position, at(position), twist, KINEMATICS.home, REST)
        position = position + 0.005 * solution.velocity
    assert (position >= KINEMATICS.lower).all() and (position <= KINEMATICS.upper).all()


def test_a_zero_twist_moves_nothing_wherever_the_posture_is_wanted() -> None:
    solution = solver().solve(KINEMATICS.home, at(KINEMATICS.home), np.zeros(6), KINEMATICS.lower, np.ones(8))
    assert not solution.velocity.any()
    assert solution.limited_by == ""


@settings(max_examples=50, deadline=None)
@given(twist=twists.filter(lambda twist: np.linalg.norm(twist) > 1e-3))
def test_the_closed_form_is_the_quadratic_programs_solution(twist: np.ndarray) -> None:
    position = KINEMATICS.home.copy()
    position[4] -= 0.3
    jacobian = at(position)
    reference = position + 0.1
    inverse = solver()
    size = float(np.linalg.norm(twist * np.array((1, 1, 1, 0.3, 0.3, 0.3))))
    wanted = np.full(8, 0.1) * min(1.0, size / module.MOVING) / size
    free = np.full(8, 1e3)
    programmed = inverse._bounded(jacobian, twist / size, wanted, -free, free, size)
    closed, price = inverse._unbounded(jacobian, twist / size, wanted)
    assert price < module.PRICE
    assert programmed.share == pytest.approx(1.0, abs=1e-6)
    assert closed * size == pytest.approx(programmed.velocity, abs=1e-5)
    within = inverse.solve(position, jacobian, 0.01 * twist / size, reference, REST)
    assert within.share == pytest.approx(1.0, abs=1e-6)


def test_near_a_singularity_the_arm_slows_down_instead_of_racing() -> None:
    position = np.array((0.2, 0.3, 0.2, 0.5, 0.0, 0.3, 0.5, 0.0))  # the elbow is straight
    jacobian = at(position)
    outwards = np.linalg.svd(jacobian)[0][:, -1]
    solution = solver().solve(position, jacobian, 0.2 * outwards, position, REST)
    assert solution.share < 0.9
    assert np.abs(solution.velocity).max() < 2.0
    assert solution.limited_by


def test_the_report_names_the_joint_that_limits() -> None:
    position = KINEMATICS.home.copy()
    position[0] = KINEMATICS.upper[0] - MARGIN[0]
    position[4] = KINEMATICS.upper[4] - MARGIN[4]
    up = np.array((0, 0, 0.3, 0, 0, 0.0))
    solution = solver().solve(position, at(position), up, position, REST)
    assert solution.share < 1.0
    assert "limit" in solution.limited_by and "_joint" in solution.limited_by


INPUTS = ("position", "jacobian", "twist", "reference", "lead")


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@settings(max_examples=100, deadline=None)
@given(
    name=st.sampled_from(INPUTS),
    number=st.sampled_from((np.nan, np.inf, -np.inf)),
    place=st.integers(0, 47),
    others=shares,
)
def test_a_number_that_is_not_finite_moves_nothing_and_harms_nothing_later(
    name: str, number: float, place: int, others: np.ndarray
) -> None:
    position = KINEMATICS.lower + others * (KINEMATICS.upper - KINEMATICS.lower)
    healthy = {
        "position": position,
        "jacobian": at(position),
        "twist": np.array((0.0, 0.0, 0.3, 0.0, 0.5, 0.0)),
        "reference": KINEMATICS.home,
        "lead": REST,
    }
    inverse = solver()
    inverse.solve(**healthy)
    spoilt = healthy[name].copy()
    spoilt.flat[place % spoilt.size] = number
    ill = inverse.solve(**(healthy | {name: spoilt}))
    assert np.isfinite(ill.velocity).all()
    assert np.abs(ill.velocity).max() <= KINEMATICS.speed.max()
    if name == "twist" or np.isnan(number):
        assert not ill.velocity.any()
        assert "not finite" in ill.limited_by
    assert inverse.solve(**healthy).velocity == pytest.approx(solver().solve(**healthy).velocity, abs=1e-6)
