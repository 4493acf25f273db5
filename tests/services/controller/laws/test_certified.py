"""The certified law against its formulas, written a second time without any of its shortcuts."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import piqp
import pytest
from scipy.spatial.transform import Rotation

from services.controller.bounds.yielding import RoundedYield, YieldInput
from services.controller.guarantee import certificates
from services.controller.laws import make_law
from services.controller.laws.certified import CertifiedLaw
from services.controller.laws.law import LawInput
from services.controller.laws.qp import QpFailure
from shared.spatial import Array
from tests.services.controller import closed_form
from tests.services.controller.contacts import ERROR, LIMIT, agile, state, unit

REACH = (0.4, 0.2, 0.1)


def make(**changes: object) -> CertifiedLaw:
    law = make_law(agile(**{"contact_stiffness": 1000.0, "contact_reach": REACH, "contact_friction": 0.3, **changes}))
    assert isinstance(law, CertifiedLaw)
    return law


def violation(law: CertifiedLaw, v: Array, wrench: Array) -> float:
    """Largest excess [N, Nm] of ``T M [q; p] <= max(0, A -+ w - M (s + T y))``, with M and the caps written again."""
    T, y, M = law.parameters.period, law.y, closed_form.rows(law.bound.matrix, law.bound.low)
    A = law.caps.rounded(law._yielding.distance) if law.rounded else law.caps.levels[0][:6]
    path = law.travel.in_flight + T * np.maximum(0.0, -closed_form.both_senses(y))
    room = np.tile(A, 2) - closed_form.both_senses(wrench) - M @ path
    used = T * M @ np.maximum(0.0, -closed_form.both_senses(v - y))
    return float(np.max(used - np.maximum(0.0, room)))


@pytest.mark.parametrize("yield_start", [1.0, 0.8])
def test_rows_hold_for_any_input(yield_start: float) -> None:
    rng = np.random.default_rng(5)
    law = make(yield_start=yield_start, delay=0.03, lag=0.01, period=0.012)
    moved = 0
    for _ in range(1500):
        wrench = LIMIT * rng.uniform(-1, 1, 6) * rng.choice((0.05, 0.5, 1.1))
        given = state(wrench, rng.normal(size=3) * 0.2, target=rng.normal(size=3) * 0.2, turn=rng.normal(size=3) * 0.3)
        output = law.step(given, 0.01)
        assert output.failure is None
        assert violation(law, output.twist, wrench) <= 1e-9
        moved += bool(np.abs(output.twist).max() > 1e-3)
    assert moved > 150


@pytest.mark.parametrize(
    "lie",
    [
        lambda rng, x: x * rng.uniform(0, 1 + 2e-7, 13),
        lambda rng, x: x * rng.uniform(0, 3, 13),
        lambda rng, x: rng.uniform(0, 1, 13),
        lambda rng, x: x * math.nan,
        lambda rng, x: -x,
    ],
)
def test_rows_hold_whatever_the_solver_answers(lie: Callable[[np.random.Generator, Array], Array]) -> None:
    rng = np.random.default_rng(6)
    law = make(delay=0.02)
    honest = law.qp._minimise
    law.qp._minimise = lambda: (piqp.PIQP_SOLVED, lie(rng, honest()[1]))
    for _ in range(300):
        wrench = LIMIT * rng.uniform(-1.1, 1.1, 6)
        output = law.step(state(wrench, target=rng.normal(size=3) * 0.2), 0.01)
        assert np.isfinite(output.twist).all()
        if output.failure is not None:
            assert law.last_failure["reason"] == output.failure and law.last_failure["rows"]
            assert output.twist == pytest.approx(law.y), "what is left without a solver is the retreat"
        assert violation(law, output.twist, wrench) <= 1e-9


def test_a_failed_solve_in_free_space_rests() -> None:
    law = make()

    def fail() -> None:
        raise QpFailure("quadratic program: out of order", {})

    law.qp.solve = fail
    output = law.step(state(target=[0.3, 0, 0]), 0.01)
    assert output.failure == "quadratic program: out of order" and not output.twist.any()


def test_optimum_in_a_box_of_single_axes() -> None:
    """With one contact axis that matters (tiny reach) the reserve alone bounds p and q: compare with the bisection."""
    rng = np.random.default_rng(7)
    compared = 0
    for _ in range(200):
        law = make(contact_stiffness=1.0, contact_reach=(0.001,) * 3, contact_friction=0.0, reserve=0.3)
        error = rng.normal(size=3)
        given = state(position=error, turn=0.1 * rng.normal(size=3), limit=LIMIT * 1e4)
        output = law.step(given, 0.01)
        v = closed_form.twist(
            np.concatenate((error, _rotation_error(given))), np.full(6, -1.0), np.full(6, 3.0), 10.0, 1.0
        )
        if np.all(np.abs(v[:3]) < 1.0):
            compared += 1
            assert output.twist == pytest.approx(closed_form.shortened(v, 1.0, 3.0), abs=1e-6)
    assert compared > 100


def _rotation_error(given: LawInput) -> Array:
    return Rotation.from_matrix(given.rotation @ given.target_rotation.T).as_rotvec()


@pytest.mark.parametrize(
    ("settings", "error_bound", "words"),
    [
        ({}, np.where(np.arange(6) == 4, 1.2, ERROR), ("3 Nm about y", "1.2")),
        ({}, -ERROR, ("error bound",)),
        ({"payload_mass": 5.0, "max_acceleration": (2.0,) * 6}, ERROR, ("error bound 10.",)),
    ],
    ids=["narrow", "negative", "inertia of the payload"],
)
def test_limits_that_errors_swallow_brake_and_say_which(
    settings: dict, error_bound: Array, words: tuple[str, ...]
) -> None:
    output = make(**settings).step(state(target=[0.3, 0, 0], error_bound=error_bound), 0.01)
    assert output.failure is not None and all(word in output.failure for word in words)
    assert not output.twist.any()


@pytest.mark.parametrize("yield_start", [1.0, 0.9])
def test_a_weight_below_the_limit_is_held_without_moving(yield_start: float) -> None:
    law = make(yield_start=yield_start)
    for _ in range(50):
        output = law.step(state([0, 0, -0.85 * LIMIT[2], 0, 0, 0]), 0.01)
        assert np.abs(output.twist).max() < 1e-6 and output.failure is None


def test_a_weight_above_the_limit_is_lowered() -> None:
    law = make()
    speeds = [law.step(state([0, 0, -11.0, 0, 0, 0]), 0.01) for _ in range(5)]
    assert all(output.twist[2] < 0 and output.yielding and output.active[2] == -1 for output in speeds)


def test_retreat_is_open_while_pressing() -> None:
    """At the cap the row is closed inward; outward the tool may leave at once."""
    law = make(contact_friction=0.0)
    pressed = [0, 0, 0.95 * LIMIT[2], 0, 0, 0]
    inward = law.step(state(pressed, target=[0, 0, -0.3]), 0.01)
    assert inward.twist[2] == pytest.approx(0.0, abs=1e-9)
    outward = make(contact_friction=0.0).step(state(pressed, target=[0, 0, 0.3]), 0.01)
    assert outward.twist[2] > 0.01


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("yield_start", [1.0, 0.8])
def test_free_approach_reaches_the_certified_speed_without_stopping(axis: int, yield_start: float) -> None:
    law = make(delay=0.03, lag=0.02, period=0.012, contact_stiffness=3000.0, yield_start=yield_start, max_linear=0.25)
    certified = certificates(law.parameters, LIMIT, ERROR)[axis].speed
    far = np.zeros(6)
    far[axis] = 2.0
    speeds = []
    for _ in range(200):
        speeds.append(law.step(state(target=far[:3], target_turn=far[3:]), 0.01).twist[axis])
    assert np.all(np.array(speeds) >= 0.97 * certified)
    assert np.all(np.array(speeds) <= 1.1 * certified)


def test_what_is_in_flight_survives_braking_and_a_change_of_law() -> None:
    law = make(delay=0.05)
    for _ in range(10):
        law.step(state(target=[1.0, 0, 0]), 0.01)
    law.brake(0.01)
    assert law.travel.in_flight[6] > 0.0
    other = make_law(agile(law="paper", delay=0.05), previous=law)
    assert other.travel is law.travel
    back = make_law(agile(delay=0.05), previous=other)
    back.brake(0.01)
    assert back.travel.in_flight[6] > 0.0


def unhindered(law: CertifiedLaw, wrench: Array) -> list[float] | None:
    """What the rounded form would do if no row held it."""
    return RoundedYield().step(
        YieldInput(wrench.tolist(), law.caps, law.bound, law.speed_box.speed, np.zeros(6), law.response_time, 0.01)
    )


def test_yielding_at_rest_keeps_its_direction_or_what_the_rows_leave_of_it() -> None:
    rng = np.random.default_rng(8)
    slow = {"max_linear": 0.02, "max_angular": 0.03, "max_acceleration": (0.5, 1.0, 0.2, 3.0, 0.4, 1.0)}
    kept = 0
    for _ in range(200):
        law = make(yield_start=0.8, **slow)
        output = law.step(state(LIMIT * unit(rng, 6) * rng.uniform(0.8, 3)), 0.01)
        assert np.linalg.norm(output.twist[:3]) <= 0.02 * (1 + 1e-9)
        assert np.linalg.norm(output.twist[3:]) <= 0.03 * (1 + 1e-9)
        wrench = np.zeros(6)
        wrench[rng.integers(6)] = 1.0
        law = make(yield_start=0.8, **slow)
        law.step(state(wrench * LIMIT * 0.86), 0.01)
        free = unhindered(law, wrench * LIMIT * 0.86)
        if free is not None and law.y.any():
            kept += 1
            assert law.y / np.linalg.norm(law.y) == pytest.approx(np.array(free) / np.linalg.norm(free), abs=1e-9)
    assert kept > 50


def test_yielding_at_rest_keeps_the_rows_with_everything_in_flight() -> None:
    """The step that makes the rounded form's proof complete: no y can carry any axis beyond its cap C."""
    rng = np.random.default_rng(9)
    shortened = 0
    for _ in range(300):
        law = make(yield_start=0.8, delay=0.03)
        for _ in range(rng.integers(1, 6)):
            law.step(state(LIMIT * rng.uniform(-0.9, 0.9, 6), target=rng.uniform(-1, 1, 3)), 0.01)
        wrench = LIMIT * rng.uniform(-0.93, 0.93, 6)
        law.step(state(wrench), 0.01)
        if law._yielding.moved:
            continue
        M = closed_form.rows(law.bound.matrix, law.bound.low)
        # The command of this step is not in flight yet.
        room = np.tile(law.caps.most, 2) - closed_form.both_senses(wrench) - M @ law.travel.in_flight
        used = law.parameters.period * M @ np.maximum(0.0, -closed_form.both_senses(law.y))
        assert np.all(used <= np.maximum(room, 0.0) + 1e-9)
        free = unhindered(law, wrench)
        shortened += free is not None and not np.allclose(law.y, free)
    assert shortened > 20


@pytest.mark.parametrize("yield_start", [1.0, 0.8])
def test_a_lower_limit_moves_the_threshold_of_yielding_with_it(yield_start: float) -> None:
    law = make(yield_start=yield_start)
    wrench = [0.0, 0.7 * LIMIT[1], 0.0, 0.0, 0.0, 0.0]
    assert not law.step(state(wrench), 0.01).yielding
    output = law.step(state(wrench, limit=0.5 * LIMIT), 0.01)
    assert output.yielding and output.twist[1] > 0.0


@pytest.mark.parametrize("start", [1.0, 0.8])
def test_changed_limits_and_errors_are_those_of_the_next_command(start: float) -> None:
    wrench = [-7.0, 0.0, 0.0, 0.0, 0.0, 0.0]  # pushed back by what lies before the target

    def speed(before: tuple[float, float]) -> float:
        law = make(yield_start=start)
        twist = np.zeros(6)
        for factor, error in (before, (1.0, 1.0)):
            given = state(wrench, target=[0.3, 0, 0], limit=factor * LIMIT, error_bound=error * ERROR)
            twist = law.step(given, 0.01).twist
            law.brake(1.0)
        return float(twist[0])

    fresh = speed((1.0, 1.0))
    assert fresh > 1e-3
    assert speed((2.0, 1.0)) == speed((1.0, 3.0)) == pytest.approx(fresh)
