"""The base moves as its gate lets it, and carries the robot: odometry, frames, and what the wrist feels of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shared import topics
from shared.messages import BaseTwistCommand
from shared.spatial import rotation_matrix
from tests.services.sim.rig import Rig

QUIET = {"ft_noise": [0.0] * 6}


def gripper_force(rig: Rig) -> np.ndarray:
    sample = rig.last(topics.SENSOR_FT)
    return rotation_matrix(sample.orientation) @ sample.force


def test_a_differential_base_drives_forwards_and_stops_when_nobody_commands() -> None:
    rig = Rig()
    rig.drive((0.3, 0.2, 0.0), 2.0)
    base = rig.last(topics.STATE_BASE)
    assert base.velocity == pytest.approx((0.3, 0.0, 0.0))
    assert "base commands clamped" in rig.last(topics.STATE_ROBOT).reason
    rig.run(1.0)
    base = rig.last(topics.STATE_BASE)
    assert base.velocity == pytest.approx((0, 0, 0))
    # Up and down at 1 m/s2; the last command acts for its ttl, of which 10 ms were part of the drive.
    travel = 0.3 * 2.0 - 0.3**2 / 2 + 0.3 * 0.09 + 0.3**2 / 2
    assert base.position == pytest.approx((travel, 0.0), abs=0.3 * 0.011)
    assert "base commands expired: 1" in rig.last(topics.STATE_ROBOT).reason


def test_a_differential_base_describes_a_circle() -> None:
    rig = Rig()
    rig.drive((0.2, 0.0, 0.5), 4.0)
    base = rig.last(topics.STATE_BASE)
    # Speeding up keeps the ratio of the two, so it is a circle of 0.4 m from the start on.
    radius = 0.2 / 0.5
    wanted = radius * math.sin(base.yaw), radius * (1.0 - math.cos(base.yaw))
    assert base.position == pytest.approx(wanted, abs=1e-6)
    assert abs(base.yaw) > 1.5


def test_an_omnidirectional_base_goes_any_way_while_it_turns() -> None:
    rig = Rig(base_type="omni")
    status = rig.last(topics.STATE_ROBOT)
    assert (status.base_type, *status.max_base) == ("omni", 1.0, 1.0, pytest.approx(math.radians(80)))
    rig.drive((0.1, -0.2, 0.0), 2.0)
    base = rig.last(topics.STATE_BASE)
    assert base.position[1] / base.position[0] == pytest.approx(-2.0)
    rig.drive((0.0, 0.0, 1.0), 5.0)
    assert -math.pi < rig.last(topics.STATE_BASE).yaw <= math.pi


def test_what_is_told_in_base_stays_the_same_while_base_moves_and_turns() -> None:
    rig = Rig(**QUIET)
    before = rig.last(topics.STATE_EE)
    rig.drive((0.2, 0.0, 0.4), 3.0)
    after = rig.last(topics.STATE_EE)
    assert after.position == pytest.approx(before.position, abs=1e-3)
    assert after.orientation == pytest.approx(before.orientation, abs=1e-3)
    assert np.linalg.norm(after.linear) < 2e-3


def test_a_tool_twist_is_relative_to_base() -> None:
    rig = Rig()
    for _ in range(100):
        rig.stack.client.publish(topics.COMMAND_BASE_TWIST, BaseTwistCommand((0.2, 0.0, 0.4), 0.1))
        rig.move((0.0, 0.0, -0.1), 0.01)
    assert rig.last(topics.STATE_EE).linear == pytest.approx((0, 0, -0.1), abs=3e-3)


def test_the_wrist_feels_the_base_speed_up_and_turn() -> None:
    rig = Rig(**QUIET)
    still = gripper_force(rig)
    mass = -still[2] / 9.81
    assert mass == pytest.approx(0.8226, abs=0.01)
    rig.drive((0.9, 0.0, 0.0), 0.5)
    # 1 m/s2 forwards: the gripper stays behind.
    assert gripper_force(rig) - still == pytest.approx((-mass, 0.0, 0.0), abs=0.1)
    rig.drive((0.0, 0.0, 1.0), 2.5)
    # The gripper's centre of mass is 6 cm behind the tool, on a circle around base.
    outwards = mass * 1.0**2 * np.array((0.4365, -0.3, 0.0))
    assert gripper_force(rig) - still == pytest.approx(outwards, abs=0.05)
    rig.drive((0.0, 0.0, 0.0), 1.5)
    assert gripper_force(rig) == pytest.approx(still, abs=0.05)


def test_the_world_stays_where_it_was_at_the_start() -> None:
    rig = Rig(base_type="omni")
    rig.drive((0.0, 0.0, 0.8), 2.5)
    yaw = rig.last(topics.STATE_BASE).yaw
    rig.drive((0.0, 0.0, 0.0), 1.0)
    yaw = rig.last(topics.STATE_BASE).yaw
    rig.ask(command="push", force=[5.0, 0.0, 0.0], duration=1.0)
    rig.run(0.2)
    wanted = 5.0 * np.array((math.cos(yaw), math.sin(yaw), 0.0))
    assert rig.last(topics.SIM_WORLD).contact_force == pytest.approx(wanted, abs=1e-6)


def test_a_bag_swings_back_when_the_base_drives_off_and_pulls_down_again_afterwards() -> None:
    rig = Rig(base_type="omni")
    rig.ask(command="load", mass=1.0)
    rig.run(1.0)
    rig.drive((0.0, 0.5, 0.0), 0.5)
    assert rig.last(topics.SIM_WORLD).contact_force[1] < -0.4
    rig.drive((0.0, 0.0, 0.0), 25.0)
    assert rig.last(topics.SIM_WORLD).contact_force == pytest.approx((0, 0, -9.81), abs=0.3)
    assert rig.last(topics.STATE_BASE).position[1] > 0.2


def test_reset_takes_the_base_back_to_the_start() -> None:
    rig = Rig()
    rig.drive((0.3, 0.0, 0.3), 1.0)
    rig.run(1.0)
    rig.ask(command="reset")
    # A reader takes over the new session once the one before has been silent for its age limit.
    rig.run(0.5)
    base = rig.last(topics.STATE_BASE)
    assert (*base.position, base.yaw) == pytest.approx((0, 0, 0))
