"""The bag on its rope: weight, swing, floor, and changes without a jump."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.sim.scene.bag import BAG_LENGTH, HANDOVER, ROPE_LENGTH, Bag
from shared.spatial import GRAVITY

STEP = 0.002
TOOL = (0.5, -0.3, 1.0)
REST = (0.0, 0.0, 0.0)


def hang(bag: Bag, duration: float, tool: tuple[float, float, float] = TOOL) -> np.ndarray:
    """Forces (n, 3) on a tool at rest."""
    return np.array([bag.step(tool, REST, STEP) for _ in range(round(duration / STEP))])


def loaded(mass: float) -> Bag:
    bag = Bag()
    bag.load(mass, TOOL)
    hang(bag, 2.0)
    return bag


@pytest.mark.parametrize("mass", [0.05, 0.5, 2.04, 2.85, 20.0])
def test_at_rest_it_pulls_with_its_weight(mass: float) -> None:
    force = hang(loaded(mass), 0.5)
    assert force[:, 2] == pytest.approx(-mass * GRAVITY, rel=1e-3)
    assert np.abs(force[:, :2]).max() < 1e-6


def test_its_bottom_hangs_four_decimetres_above_the_floor() -> None:
    bag = loaded(2.04)
    assert bag.height == pytest.approx(1.0 - ROPE_LENGTH - BAG_LENGTH, abs=0.01)


@pytest.mark.parametrize(("before", "after"), [(0.0, 2.04), (2.04, 2.85), (2.85, 2.04), (2.85, 0.0)])
def test_a_change_of_mass_jumps_neither_in_force_nor_in_place(before: float, after: float) -> None:
    bag = loaded(before) if before else Bag()
    height = bag.height
    bag.load(after, TOOL)
    force = hang(bag, HANDOVER - STEP)
    steps = np.diff(np.concatenate(([[0, 0, -before * GRAVITY]], force)), axis=0)
    assert np.abs(steps).max() < 0.5
    if before and after:
        assert abs(bag.height - height) < 0.01
    settled = hang(bag, 2.0)
    # No overshoot that would count as a heavier bag.
    assert -settled[:, 2].min() <= max(before, after) * GRAVITY * 1.02 + 0.1
    assert settled[-1, 2] == pytest.approx(-after * GRAVITY, abs=1e-2)


def test_taken_off_it_is_gone() -> None:
    bag = loaded(2.04)
    bag.load(0.0, TOOL)
    hang(bag, HANDOVER + 2 * STEP)
    assert not bag.present
    assert bag.step(TOOL, REST, STEP) == REST
    bag.load(0.0, TOOL)
    assert not bag.present


def test_a_second_bag_is_hung_as_gently_as_the_first() -> None:
    bag = loaded(1.0)
    bag.load(0.0, TOOL)
    hang(bag, 2.0)
    bag.load(1.0, TOOL)
    assert hang(bag, 2.0)[:, 2].min() > -1.02 * GRAVITY


def test_set_down_it_rests_on_the_floor_and_the_rope_goes_slack() -> None:
    bag = loaded(2.85)
    drop = bag.height
    heights = []
    for step in range(3000):
        z = TOOL[2] - min(0.1 * step * STEP, drop + 0.1)
        force = bag.step((TOOL[0], TOOL[1], z), (0, 0, -0.1 if z > TOOL[2] - drop - 0.1 else 0.0), STEP)
        heights.append(bag.height)
    assert force == REST
    assert -0.01 < heights[-1] < 0.0
    assert np.ptp(heights[-250:]) < 1e-4


def test_lifted_again_its_weight_comes_back() -> None:
    bag = loaded(2.0)
    hang(bag, 2.0, (0.5, -0.3, 0.55))
    assert bag.step((0.5, -0.3, 0.55), REST, STEP) == REST
    force = hang(bag, 3.0, TOOL)
    assert force[-1, 2] == pytest.approx(-2.0 * GRAVITY, rel=1e-2)


def test_it_swings_like_a_pendulum_and_comes_to_rest() -> None:
    bag = loaded(2.0)
    tool = (0.55, -0.3, 1.0)
    crossings, last = [], 0.0
    for step in range(4000):
        bag.step(tool, REST, STEP)
        offset = bag.top[0] - tool[0]
        if last < 0.0 <= offset:
            crossings.append(step * STEP)
        last = offset
    period = np.mean(np.diff(crossings))
    assert period == pytest.approx(2 * math.pi * math.sqrt(ROPE_LENGTH / GRAVITY), rel=0.05)
    hang(bag, 20.0, tool)
    assert abs(bag.top[0] - tool[0]) < 2e-3
