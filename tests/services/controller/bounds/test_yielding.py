"""Yielding: the formulas, their direction, and when motion of the environment counts as proven."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from services.controller.bounds.caps import Caps
from services.controller.bounds.stiffness_bound import ContactZone, StiffnessBound
from services.controller.bounds.yielding import RoundedYield, StrictYield, Yielding, YieldInput, scaled_into
from tests.services.controller.contacts import ERROR, LIMIT, bound, jacobian, tangent

D, DT = 0.05, 0.01
SPEED = [0.25] * 3 + [0.5] * 3
ZONE = ContactZone(800.0, (0.5, 0.3, 0.1))


KBAR = bound(ZONE, force=(10.0, 10.0, 10.0))


def caps(yield_start: float) -> Caps:
    caps = Caps(0.1, yield_start)
    caps.update(LIMIT, ERROR)
    caps.lower(np.zeros(12))
    return caps


def state(
    wrench: Sequence[float], c: Caps, Kbar: StiffnessBound = KBAR, speed: Sequence[float] = SPEED, dt: float = DT
) -> YieldInput:
    return YieldInput(list(wrench), c, Kbar, speed, np.zeros(6), D, dt)


def along_x(force: float) -> list[float]:
    return [force, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_strict_form_rests_up_to_the_limit_and_its_error() -> None:
    step = StrictYield().step
    for side in (-1, 1):
        wrench = (side * (LIMIT + ERROR)).tolist()
        assert step(state(wrench, caps(1.0))) is None


def test_strict_form_is_the_formula() -> None:
    c = caps(1.0)
    wrench = np.array((12.0, -13.0, 5.0, 0.0, 3.5, 0.0))
    y = np.array(StrictYield().step(state(wrench.tolist(), c, KBAR, [10.0] * 6, DT)))
    K, wall = KBAR.matrix, np.array(c.wall)
    stiffness = KBAR.largest([0, 1, 4], KBAR.roots)
    for i in range(6):
        excess = max(0.0, abs(wrench[i]) - wall[i])
        expected = np.sign(wrench[i]) * excess / (K[i, i] * stiffness * D)
        assert y[i] == pytest.approx(expected * (1 + DT / (4 * D)), abs=1e-15)


def test_integral_grows_saturates_and_decays() -> None:
    yielding, c = StrictYield(), caps(1.0)
    wrench = along_x(11.0)
    speeds = [yielding.step(state(wrench, c))[0] for _ in range(3000)]
    assert speeds[100] > 2 * speeds[0] and max(speeds) <= SPEED[0] + speeds[0]
    rest = [0.0] * 6
    for _ in range(200):
        after = yielding.step(state(rest, c))
    assert after is None


@pytest.mark.parametrize("form", [StrictYield, RoundedYield])
def test_a_push_is_forgotten_while_the_tool_rests(form: type[Yielding]) -> None:
    yielding, c = form(), caps(1.0 if form is StrictYield else 0.8)
    for _ in range(300):
        yielding.step(state(along_x(9.0 if form is RoundedYield else 11.0), c))
    assert not yielding.at_rest
    for _ in range(40):
        yielding.brake(D, 0.05)
    assert yielding.at_rest and yielding.step(state([0.0] * 6, c)) is None


def test_rounded_form_begins_at_its_threshold_and_follows_the_gradient() -> None:
    c = caps(0.8)
    start, room = np.array(c.start), np.array(c.room)
    assert RoundedYield().step(state((0.999 * start).tolist(), c)) is None
    wrench = start * np.array((1.1, -1.05, 0.5, 0.0, 0.0, 0.2))
    yielding = RoundedYield()
    y = np.array(yielding.step(state(wrench.tolist(), c, KBAR, SPEED, 1e-12)))
    gradient = np.sign(wrench) * np.maximum(0.0, np.abs(wrench) - start) / room**2
    assert y / np.linalg.norm(y) == pytest.approx(gradient / np.linalg.norm(gradient), abs=1e-9)


@pytest.mark.parametrize("yield_start", [0.8, 1.0])
def test_no_passive_contact_is_driven_further_out_of_the_box(yield_start: float) -> None:
    """One answer of duration D, held, from any wrench: the distance does not grow, whatever the contact."""
    rng = np.random.default_rng(4)
    free = bound(ZONE)
    c = caps(yield_start)
    answered = 0
    for _ in range(2000):
        wrench = LIMIT * rng.uniform(-1, 1, 6) * (1.0 if yield_start < 1.0 else 2.0)
        yielding = StrictYield() if yield_start == 1.0 else RoundedYield()
        y = yielding.step(state(wrench.tolist(), c, free, [1e9] * 6, 1e-12))
        if y is None:
            continue
        box = np.array(c.wall if yield_start == 1.0 else c.start)
        scale = np.array(free.roots if yielding.moved else c.room)
        J = jacobian(np.array(ZONE.reach) * rng.uniform(-1, 1, 3))
        K = J.T @ tangent(rng, ZONE.stiffness, 0.0) @ J
        before, after = (
            np.linalg.norm(np.maximum(0.0, np.abs(w) - box) / scale) for w in (wrench, wrench - D * K @ np.array(y))
        )
        answered += 1
        assert after <= before + 1e-9
    assert answered > 500


def test_a_wrench_beyond_the_wall_proves_motion_until_it_is_back_in_the_box() -> None:
    c, yielding = caps(0.8), RoundedYield()

    def force(x: float) -> list[float] | None:
        return yielding.step(state(along_x(x), c))

    assert c.start[0] < c.most[0] < c.wall[0] <= LIMIT[0] + 1.1 * ERROR[0]
    force(0.999 * c.wall[0])
    assert not yielding.moved
    force(1.001 * c.wall[0])
    assert yielding.moved
    for _ in range(20):
        force(0.5 * (c.start[0] + c.wall[0]))
    assert yielding.moved
    y = force(0.9 * c.start[0])
    assert yielding.moved, "it still follows"
    while yielding.moved:
        y = force(0.9 * c.start[0])
    assert y is not None and 0.0 < y[0] < 1e-3, "what is left is the rows' to limit"


def test_after_a_long_brake_motion_has_to_be_proven_again() -> None:
    c, yielding = caps(0.8), RoundedYield()
    for _ in range(20):
        yielding.step(state(along_x(1.1 * c.wall[0]), c))
    yielding.brake(D, DT)
    assert yielding.moved, "a tick's brake changes nothing"
    for _ in range(100):
        yielding.brake(D, DT)
    assert not yielding.moved


def test_scaling_keeps_the_direction() -> None:
    assert scaled_into([1.0, 2.0, 0, 0, 0, -1.0], [0.5] * 6) == pytest.approx([0.25, 0.5, 0, 0, 0, -0.25])
    assert scaled_into([0.1] * 6, [0.5] * 6) == [0.1] * 6
    assert scaled_into([1.0, 0, 0, 0, 0, 0], [0.0] * 6) == [0.0] * 6
