"""Level assist: which way it goes, its dead band, its bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.task.geometry import Pose
from services.task.level_assist import DEAD_BAND, FARTHEST, RELAXATION, LevelAssist, far_end_drop

LENGTH = 1.2
angles = st.floats(-0.6, 0.6)


def tool(pitch: float = 0.0, yaw: float = 0.0, roll: float = 0.0) -> Pose:
    return Pose.from_rpy((0.5, -0.3, 0.8), (roll, pitch, yaw))


@given(angles, angles, st.floats(-math.pi, math.pi))
def test_offset_is_by_how_much_the_far_end_is_lower(pitch: float, yaw: float, roll: float) -> None:
    pose = tool(pitch, yaw, roll)
    lower = pose.position[2] - pose.shifted(LENGTH).position[2]
    assert far_end_drop(pose, np.zeros(3), LENGTH, 0.01) == pytest.approx(lower, abs=1e-9)


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(-20.0, 20.0))
def test_a_hand_that_presses_the_far_end_down_counts_as_lower(yaw: float, roll: float, down: float) -> None:
    pose = tool(0.0, yaw, roll)
    torque = np.cross(LENGTH * pose.rotation[:, 0], np.array((0.0, 0.0, -down)))
    assert far_end_drop(pose, torque, LENGTH, 0.01) == pytest.approx(LENGTH * 0.01 * LENGTH * down, abs=1e-9)


@given(st.floats(-1.0, 1.0))
def test_target_goes_to_where_the_far_end_is_and_no_farther(offset: float) -> None:
    height = LevelAssist(1.0, 0.8).update(0.8, offset, 0.02)
    assert abs(height - 0.8) <= FARTHEST + 1e-12
    if abs(offset) > DEAD_BAND:
        assert height == pytest.approx(0.8 - max(-FARTHEST, min(FARTHEST, offset)))
    else:
        assert height == 0.8


def test_inside_the_dead_band_it_comes_back_to_the_tool() -> None:
    assist = LevelAssist(1.0, 0.8)
    assist.update(0.8, 0.1, 0.02)
    heights = [assist.update(0.8, 0.01, 0.02) for _ in range(400)]
    assert np.all(np.diff(heights) <= RELAXATION * 0.02 + 1e-12) and np.all(np.diff(heights) >= 0.0)
    assert heights[0] == pytest.approx(0.7 + RELAXATION * 0.02) and heights[-1] == pytest.approx(0.8)


def test_half_the_share_is_half_the_way() -> None:
    assert LevelAssist(0.5, 0.8).update(0.8, 0.2, 0.02) == pytest.approx(0.7)


def test_it_goes_on_from_a_target_of_before_a_restart_without_a_jump() -> None:
    assist = LevelAssist(1.0, 0.78)
    assert assist.update(0.8, 0.0, 0.02) == pytest.approx(0.78 + RELAXATION * 0.02)
