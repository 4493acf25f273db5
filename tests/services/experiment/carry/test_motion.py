"""Motion of the hands relative to the base, and how fast axes turn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from services.experiment.carry.motion import Motion, spin
from shared.spatial import Array
from tests.services.experiment.carry.motions import guided

TIME = np.arange(0.0, 4.0, 1 / 30)
IN_BASE = np.array((1.7, -0.4, 0.9))  # [m] the hands
TOOL = np.array((0.5, -0.4, 0.9))


def held(base: Array, hand: Array, axes: Rotation) -> Motion:
    return guided(TIME, base, hand, axes, TOOL)


def test_who_walks_and_turns_with_the_base_does_not_move_in_it() -> None:
    base = np.column_stack((0.3 * TIME, np.sin(TIME), 0.4 * TIME))
    still = held(base, np.tile(IN_BASE, (len(TIME), 1)), Rotation.identity(len(TIME)))
    assert np.abs(still.twist_in_base).max() < 2e-3


def test_turning_about_the_tool_moves_nothing_there_and_turning_about_the_hands_does() -> None:
    axes = Rotation.from_rotvec(np.outer(0.2 * TIME, (0.0, 0.0, 1.0)))
    inner = slice(5, -5)
    rest = np.zeros((len(TIME), 3))
    about_hands = held(rest, np.tile(IN_BASE, (len(TIME), 1)), axes).twist_in_base[inner]
    assert about_hands == pytest.approx(np.tile((0.0, -0.24, 0.0, 0.0, 0.0, 0.2), (len(about_hands), 1)), abs=1e-3)
    about_tool = held(rest, TOOL + axes.apply(IN_BASE - TOOL), axes).twist_in_base[inner]
    assert about_tool == pytest.approx(np.tile((0.0, 0.0, 0.0, 0.0, 0.0, 0.2), (len(about_tool), 1)), abs=1e-3)


def test_spin_is_the_angular_velocity_in_world() -> None:
    start = Rotation.from_euler("xyz", (0.3, -0.5, 1.0))
    axes = (Rotation.from_rotvec(np.outer(TIME, (0.1, -0.2, 0.3))) * start).as_matrix()
    assert spin(TIME, axes)[20] == pytest.approx((0.1, -0.2, 0.3), abs=1e-3)
