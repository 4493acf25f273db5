"""Limits and nominal wrench in force while the target changes them."""

from __future__ import annotations

import numpy as np
import pytest

from services.controller.limits_in_force import LimitsInForce

HIGH, LOW = np.full(6, 20.0), np.full(6, 5.0)
NONE, SOME = np.zeros(6), np.array((0.0, 0.0, -7.0, 0.0, 0.0, 0.0))


def test_first_target_holds_at_once() -> None:
    in_force = LimitsInForce()
    in_force.follow(LOW, SOME, 0.01)
    assert np.array_equal(in_force.limit, LOW) and np.array_equal(in_force.nominal, SOME)


def test_a_higher_limit_holds_at_once_and_a_lower_one_without_a_jump() -> None:
    in_force = LimitsInForce()
    in_force.follow(LOW, NONE, 0.01)
    in_force.follow(HIGH, NONE, 0.01)
    assert np.array_equal(in_force.limit, HIGH)
    limits = []
    for _ in range(200):
        in_force.follow(LOW, NONE, 0.01)
        limits.append(in_force.limit[0])
    steps = -np.diff([20.0, *limits])
    assert np.all(steps >= 0) and steps.max() <= 0.02 * 20.0 + 1e-9
    assert limits[-1] == 5.0


def test_nominal_wrench_moves_at_most_by_the_limit_in_half_a_second() -> None:
    in_force = LimitsInForce()
    in_force.follow(LOW, NONE, 0.01)
    in_force.follow(LOW, SOME, 0.01)
    assert in_force.nominal[2] == pytest.approx(-0.1)
    for _ in range(100):
        in_force.follow(LOW, SOME, 0.01)
    assert np.array_equal(in_force.nominal, SOME)


def test_a_long_pause_is_no_jump_beyond_the_goal() -> None:
    in_force = LimitsInForce()
    in_force.follow(HIGH, NONE, 0.01)
    in_force.follow(LOW, SOME, 100.0)
    assert np.array_equal(in_force.limit, LOW) and np.array_equal(in_force.nominal, SOME)
