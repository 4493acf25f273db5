"""The arm as a whole: holds under load, follows twists, reaches down, and gives way only where its motors must."""

from __future__ import annotations

import numpy as np
import pytest

from services.sim.robot.arm import DRIVE_LAG, SLACK, Arm
from services.sim.robot.kinematics import CARRY_HOME
from services.sim.robot.physics import FRICTION
from services.sim.scene.grip import ANGULAR_DAMPING
from shared.spatial import rotation_vector

STEP = 0.002
NONE = [0.0, 0.0, 0.0]
STILL = np.zeros(6)


@pytest.fixture
def arm() -> Arm:
    return Arm(STEP)


def run(arm: Arm, twist: np.ndarray, duration: float, force: list[float] | None = None) -> None:
    for _ in range(round(duration / STEP)):
        arm.advance(twist, force or NONE, None)


@pytest.mark.parametrize("force", [[0, 0, -20.0], [0, 0, -33.0], [30, 0, -20.0], [0, 20, 0], [0, -25, 0]])
def test_a_load_moves_the_held_tool_by_less_than_a_millimetre(arm: Arm, force: list[float]) -> None:
    before = arm.tool_position
    run(arm, STILL, 2.0, force)
    assert np.linalg.norm(arm.tool_position - before) < 1e-3


def test_without_a_command_the_set_points_do_not_move_at_all(arm: Arm) -> None:
    run(arm, np.array((0.05, 0, -0.05, 0, 0, 0.1)), 0.5)
    run(arm, STILL, 0.5)
    held = arm._set_point.copy()
    run(arm, STILL, 1.0, [0, 0, -20.0])
    assert arm._set_point == held


@pytest.mark.parametrize("axis", range(6))
def test_a_twist_is_followed_along_its_axis_only(arm: Arm, axis: int) -> None:
    twist = np.zeros(6)
    # Towards the robot's body there is less room than this test needs.
    twist[axis] = 0.05 if axis == 0 else -0.05
    start, before = arm.tool_position, arm.kinematics.tool()[1]
    run(arm, twist, 1.0)
    assert arm.tool_twist == pytest.approx(twist, abs=1e-3)
    run(arm, STILL, 0.3)
    travel = np.concatenate((arm.tool_position - start, rotation_vector(arm.kinematics.tool()[1] @ before.T)))
    assert travel == pytest.approx(twist, abs=5e-4)


def test_the_drives_lag_is_what_it_says(arm: Arm) -> None:
    start = arm.tool_position[2]
    run(arm, np.array((0, 0, -0.1, 0, 0, 0.0)), 0.5)
    behind = 0.5 - (start - arm.tool_position[2]) / 0.1
    assert DRIVE_LAG - 2 * STEP < behind < DRIVE_LAG + 2 * STEP


def test_it_lowers_a_heavy_load_by_six_decimetres_and_comes_back(arm: Arm) -> None:
    load = [0.0, 0.0, -28.0]
    down = np.array((0, 0, -0.1, 0, 0, 0.0))
    effort = 0.0
    for _ in range(60):
        run(arm, down, 0.1, load)
        effort = max(effort, float((np.abs(arm.physics.effort()) / arm.kinematics.effort).max()))
    assert arm.tool_position == pytest.approx((0.5, -0.3, 0.4), abs=5e-3)
    assert np.linalg.norm(rotation_vector(arm.kinematics.tool()[1])) < 5e-3
    assert effort <= 1.0 + 1e-9
    run(arm, -down, 6.0)
    run(arm, STILL, 0.3)
    assert arm.tool_position == pytest.approx((0.5, -0.3, 1.0), abs=5e-3)


def test_at_the_end_of_its_reach_it_stops_and_says_why(arm: Arm) -> None:
    run(arm, np.array((0.25, 0, 0, 0, 0, 0)), 4.0)
    assert np.linalg.norm(arm.tool_twist[:3]) < 0.05
    assert arm.limited_by
    low, high = arm.kinematics.lower, arm.kinematics.upper
    assert (arm.physics.position >= low - 1e-3).all() and (arm.physics.position <= high + 1e-3).all()


@pytest.mark.parametrize("force", [[0, 30.0, 0], [0, 0, -60.0]])
def test_an_overloaded_arm_gives_way_slowly_and_does_not_spring_back(arm: Arm, force: list[float]) -> None:
    before = arm.tool_position
    run(arm, STILL, 0.3, force)
    assert 0.005 < np.linalg.norm(arm.tool_position - before) < 0.1
    assert np.abs(arm.physics.effort()).max() <= arm.kinematics.effort.max()
    run(arm, STILL, 0.7, force)
    pushed = arm.tool_position
    assert np.abs(arm._set_point - arm.physics.position).max() < 1.1 * SLACK
    run(arm, STILL, 1.0)
    assert np.linalg.norm(arm.tool_position - pushed) < 0.03
    assert np.linalg.norm(arm.tool_position - before) > 0.03


@pytest.mark.parametrize("joint", [5, 6, 7])
def test_an_overloaded_wrist_does_not_shake_against_a_panel_in_its_fingers(joint: int) -> None:
    """What is gripped resists the hand's turning, one step late, as it does in the simulation."""
    arm, sway = Arm(STEP, CARRY_HOME), np.random.default_rng(joint)
    axis = arm.kinematics.jacobian()[3:, joint]
    push = 1.2 * (arm.kinematics.effort[joint] + FRICTION[joint]) * axis
    speeds = []
    for _ in range(250):
        torque = push - ANGULAR_DAMPING * arm.tool_twist[3:] + sway.normal(0.0, 0.02, 3)
        arm.advance(STILL, NONE, torque.tolist())
        speeds.append(arm.physics.velocity[joint])
    assert np.abs(speeds[-100:]).mean() > 0.02, "it gives way"
    assert np.abs(np.diff(speeds[-100:])).max() < 0.05


def test_reset_brings_it_home(arm: Arm) -> None:
    home = arm.tool_position
    run(arm, np.array((0, 0.1, -0.1, 0, 0, 0)), 0.5)
    arm.reset()
    run(arm, STILL, 0.2)
    assert arm.tool_position == pytest.approx(home, abs=1e-4)
