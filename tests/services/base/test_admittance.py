"""The body against the closed form of a damped rigid body, at any rate, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.base.admittance import REST, Admittance, SpeedLimits

FREE = Admittance(10.0, 2.0, 20.0, 10.0, 1e3, 1e3)
BODY = Admittance(10.0, 2.0, 20.0, 10.0, 0.7, 2.0)
WIDE = SpeedLimits(10.0, 10.0, 10.0, 10.0, 10.0)
NARROW = SpeedLimits(0.4, 0.2, 0.3, 0.35, 0.4)

wrenches = st.tuples(*[st.floats(-1e6, 1e6) | st.floats(-20, 20)] * 3)
durations = st.floats(0.0, 0.1)


def intervals(kind: str, duration: float) -> list[float]:
    if kind == "irregular":
        cuts = np.sort(np.random.default_rng(0).uniform(0.0, duration, 60))
        return list(np.diff((0.0, *cuts, duration)))
    rate = float(kind)
    return [1.0 / rate] * round(duration * rate)


@pytest.mark.parametrize("kind", ["30", "100", "500", "irregular"])
def test_the_step_response_is_the_closed_form_at_every_instant(kind: str) -> None:
    velocity, time = REST, 0.0
    for dt in intervals(kind, 2.0):
        velocity, time = FREE.follow(velocity, (7.0, -3.0, 2.0), WIDE, dt), time + dt
        linear, angular = 1.0 - math.exp(-20.0 * time / 10.0), 1.0 - math.exp(-10.0 * time / 2.0)
        expected = (7.0 / 20.0 * linear, -3.0 / 20.0 * linear, 2.0 / 10.0 * angular)
        assert velocity == pytest.approx(expected, rel=1e-9)


def test_without_a_force_it_coasts_with_the_time_constant_of_the_body() -> None:
    velocity = FREE.follow((0.3, 0.1, -0.2), REST, WIDE, 0.5)
    assert velocity == pytest.approx((0.3 / math.e, 0.1 / math.e, -0.2 * math.exp(-2.5)))


@given(wrenches, st.lists(st.floats(1e-4, 0.1), min_size=1, max_size=20))
def test_limited_motion_does_not_depend_on_the_rate_either(wrench, steps) -> None:
    velocity = (-0.1, 0.2, 0.3)
    once = BODY.follow(velocity, wrench, NARROW, sum(steps))
    for dt in steps:
        velocity = BODY.follow(velocity, wrench, NARROW, dt)
    assert velocity == pytest.approx(once, abs=1e-9)


def test_limited_acceleration_against_small_steps_of_the_equation() -> None:
    velocity, dt = np.array((-0.2, 0.1)), 1e-5
    for _ in range(40_000):
        acceleration = (np.array((9.0, -6.0)) - 20.0 * velocity) / 10.0
        velocity = velocity + dt * acceleration / max(1.0, np.linalg.norm(acceleration) / 0.7)
    exact = BODY.follow((-0.2, 0.1, 0.0), (9.0, -6.0, 0.0), WIDE, 0.4)
    assert exact[:2] == pytest.approx(velocity, abs=1e-5)


def within(velocity, limits: SpeedLimits) -> bool:
    vx, vy, wz = velocity
    slack = 1.0 + 1e-12
    return (
        -limits.backwards * slack <= vx <= limits.forwards * slack
        and abs(vy) <= limits.sideways * slack
        and math.hypot(vx, vy) <= limits.linear * slack
        and abs(wz) <= limits.angular * slack
    )


@given(st.lists(st.tuples(wrenches, durations), min_size=1, max_size=30))
def test_it_never_leaves_the_limits_of_speed_and_acceleration(pushes) -> None:
    velocity = REST
    for wrench, dt in pushes:
        before, velocity = velocity, BODY.follow(velocity, wrench, NARROW, dt)
        assert within(velocity, NARROW)
        change = np.subtract(velocity, before)
        assert math.hypot(*change[:2]) <= 0.7 * dt + 1e-12 and abs(change[2]) <= 2.0 * dt + 1e-12


@given(wrenches)
def test_a_base_that_cannot_go_sideways_does_not(wrench) -> None:
    vx, vy, wz = BODY.follow(REST, wrench, SpeedLimits(0.4, 0.2, 0.0, 0.4, 0.4), 0.1)
    assert vy == 0.0 and vx * wrench[0] >= 0.0 and wz * wrench[2] >= 0.0


def test_a_speed_limit_of_the_norm_keeps_the_direction() -> None:
    assert WIDE.clip((30.0, 40.0, -50.0)) == pytest.approx((6.0, 8.0, -10.0))


def test_what_a_base_cannot_do_takes_no_share_of_its_speed() -> None:
    assert SpeedLimits(0.4, 0.2, 0.0, 0.4, 0.4).clip((0.9, 0.9, 0.1)) == (0.4, 0.0, 0.1)


@pytest.mark.parametrize("kind", ["30", "100", "500", "irregular"])
def test_braking_takes_speed_over_acceleration_and_keeps_the_direction(kind: str) -> None:
    velocity, time = (0.3, -0.4, 0.6), 0.0
    for dt in intervals(kind, 1.0):
        velocity, time = BODY.brake(velocity, dt), time + dt
        share = max(0.0, 1.0 - 0.7 * time / 0.5)
        expected = (0.3 * share, -0.4 * share, max(0.0, 0.6 - 2.0 * time))
        assert velocity == pytest.approx(expected, abs=1e-12)
    assert velocity == REST
