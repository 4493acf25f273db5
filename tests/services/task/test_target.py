"""Where the tool is wanted while carrying, and the arithmetic of poses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.task.geometry import Pose, outside, roll_since, wrapped
from services.task.parameters import TaskParameters
from services.task.target import LEEWAY, SNAP_BEYOND, carrying_target
from shared.spatial import rotation_from_vector

HOME = Pose.from_rpy((0.55, -0.3, 0.8), (-math.pi / 2, 0.02, 0.1))
tilts = st.floats(-0.6, 0.6)
turns = st.floats(-2.5, 2.5)


def carried(roll: float, pitch: float, yaw: float) -> Pose:
    return Pose.from_rpy((0.6, -0.2, 0.6), (HOME.rpy[0] + roll, pitch, yaw))


@given(turns, tilts, tilts)
def test_x_y_and_yaw_are_those_of_home_pitch_is_the_tool_s(roll: float, pitch: float, yaw: float) -> None:
    target = carrying_target(HOME, carried(roll, pitch, yaw), 0.7, fixed=False)
    assert target.position == pytest.approx((0.55, -0.3, 0.7))
    assert target.rpy[2] == pytest.approx(0.1, abs=1e-9)
    assert target.rpy[1] == pytest.approx(pitch, abs=1e-9)


@given(turns)
def test_roll_is_free_and_snaps_near_a_quarter_turn(roll: float) -> None:
    target = carrying_target(HOME, carried(roll, 0.0, 0.1), 0.7, fixed=False)
    if abs(roll) <= SNAP_BEYOND or abs(abs(roll) - math.pi / 2) <= LEEWAY:
        assert abs(wrapped(roll_since(HOME, target) - roll)) < 1e-6
    else:
        assert abs(roll_since(HOME, target)) - math.pi / 2 == pytest.approx(
            math.copysign(LEEWAY, abs(roll) - math.pi / 2), abs=1e-6
        )


def test_fixed_as_in_the_paper() -> None:
    assert carrying_target(HOME, carried(1.0, 0.2, 0.3), 0.7, fixed=True) is HOME


@given(turns, tilts, tilts)
def test_turning_about_its_own_axis_is_the_roll(turn: float, pitch: float, yaw: float) -> None:
    pose = Pose.from_rpy((0.0, 0.0, 0.0), (0.4, pitch, yaw))
    turned = pose @ Pose(np.zeros(3), rotation_from_vector((turn, 0.0, 0.0)))
    assert roll_since(pose, turned) == pytest.approx(turn, abs=1e-9)


@given(st.floats(-50.0, 50.0))
def test_wrapped_is_the_same_angle_within_half_a_turn(angle: float) -> None:
    assert -math.pi <= wrapped(angle) <= math.pi
    assert math.cos(wrapped(angle)) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped(angle)) == pytest.approx(math.sin(angle), abs=1e-9)


def test_default_grasp_takes_the_near_edge_from_the_robot_s_side() -> None:
    """The panel lies flat, the marker's top points away from the robot."""
    settings = TaskParameters()
    marker = Pose.from_rpy((0.85, -0.3, 0.825), (0.0, 0.0, -math.pi / 2))
    grasp = marker @ Pose.from_rpy(settings.grasp_position, settings.grasp_rpy)
    assert grasp.position == pytest.approx((0.6, -0.3, 0.8))
    assert grasp.rotation[:, 0] == pytest.approx((1.0, 0.0, 0.0), abs=1e-9), "forward"
    assert abs(grasp.rotation[2, 1]) == pytest.approx(1.0), "the fingers open up and down"


def test_outside_names_the_coordinate_and_its_range() -> None:
    assert not outside(np.array((0.5, 0.0, 0.8)), (0.4, -0.5, 0.3), (0.7, 0.1, 1.1))
    assert outside(np.array((0.9, 0.0, 0.8)), (0.4, -0.5, 0.3), (0.7, 0.1, 1.1)) == (
        "x is 0.90 m, within reach is 0.4 to 0.7 m"
    )
