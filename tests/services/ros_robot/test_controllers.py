"""Group velocity controllers hold for ever; the controller manager lists and switches; the base halts by itself."""

from __future__ import annotations

import numpy as np
import pytest

from services.ros_robot.base_controller import COMMAND_TIMEOUT, BaseController
from services.ros_robot.controller_manager import ControllerManager
from services.ros_robot.messages import Middleware, Point, Trajectory, Velocities
from services.ros_robot.velocity_controller import GroupVelocityController
from shared.robot.profile import Profile
from shared.robot.tiago import BASES

ARM, SPEED = "arm_right_controller", "arm_right_forward_velocity_controller"
PROFILES = {which: Profile.load(f"tiago-{which}") for which in ("ros1", "ros2")}
HALF = np.full(7, 0.5)


def group() -> GroupVelocityController:
    made = GroupVelocityController("g", ("a", "b"), np.array((-1.0, -1.0)), np.array((1.0, 1.0)), np.array((2.0, 2.0)))
    made.running = True
    return made


def test_the_last_velocities_are_held_for_ever() -> None:
    speed = group()
    speed.command(Velocities(np.array((0.1, 0.0))))
    for _ in range(500):
        position, velocity = speed.advance(0.01)
    assert position == pytest.approx((0.5, 0.0)) and velocity == pytest.approx((0.1, 0.0))


def test_a_command_of_wrong_length_is_refused_and_the_old_one_goes_on() -> None:
    speed = group()
    speed.command(Velocities(np.array((0.1, 0.0))))
    assert "wants 2" in speed.command(Velocities(np.zeros(3)))
    assert speed.advance(1.0)[1] == pytest.approx((0.1, 0.0))


def test_a_limit_ends_the_way() -> None:
    speed = group()
    speed.command(Velocities(np.array((9.0, -0.5))))
    position, _ = speed.advance(0.25)
    assert position == pytest.approx((0.5, -0.125))
    speed.advance(2.0)
    assert speed.advance(2.0)[0] == pytest.approx((1.0, -1.0))


def manager(which: Middleware = "ros1", switchable: bool = True) -> ControllerManager:
    return ControllerManager(PROFILES[which], {"arm_right_1_joint": 0.4}, switchable)


def states(of: ControllerManager) -> dict[str, str]:
    return {row.name: row.state for row in of.listed()}


@pytest.mark.parametrize(
    ("which", "running", "stopped"), [("ros1", "running", "stopped"), ("ros2", "active", "inactive")]
)
def test_trajectory_controllers_run_and_the_velocity_controller_is_loaded(
    which: Middleware, running: str, stopped: str
) -> None:
    listed = states(manager(which))
    assert listed.pop(SPEED) == stopped
    assert set(listed) == {row.controller for row in PROFILES[which].controllers.values()}
    assert set(listed.values()) == {running}


def test_a_switch_hands_the_joints_over_where_they_are_and_clears_old_commands() -> None:
    robot = manager()
    topic = f"/{SPEED}/command"
    assert "not running" in robot.command(topic, Velocities(HALF), 0.0, 0.0)
    assert robot.switch([SPEED], [ARM])
    assert robot.command(topic, Velocities(HALF), 0.0, 0.0) == ""
    robot.advance(0.1, 0.1)
    assert robot.position["arm_right_1_joint"] == pytest.approx(0.45)
    assert robot.switch([ARM], [SPEED]) and robot.switch([SPEED], [ARM])
    robot.advance(0.2, 0.1)
    assert robot.position["arm_right_1_joint"] == pytest.approx(0.45)


@pytest.mark.parametrize(
    ("start", "stop"), [([SPEED], []), (["nobody"], []), ([], ["nobody"]), ([ARM], []), ([], [SPEED])]
)
def test_a_strict_switch_is_done_as_a_whole_or_not_at_all(start: list[str], stop: list[str]) -> None:
    robot = manager()
    before = states(robot)
    assert not robot.switch(start, stop)
    assert states(robot) == before


def test_a_best_effort_switch_does_what_can_be_done() -> None:
    robot = manager()
    assert robot.switch([SPEED, "nobody"], [ARM], strictness=1)
    assert states(robot)[SPEED] == "running"


def test_a_manager_that_cannot_switch_leaves_the_arm_without_a_controller() -> None:
    robot = manager(switchable=False)
    assert states(robot)[ARM] == "stopped"
    assert not robot.switch([ARM], [])


def test_while_the_emergency_stop_is_pressed_nothing_is_taken_and_afterwards_nothing_resumes() -> None:
    robot = manager()
    row = PROFILES["ros1"].controllers["arm"]
    goal = Trajectory(row.joints, (Point(1.0, np.ones(7)),))
    robot.command(row.topic, goal, 0.0, 0.0)
    robot.advance(0.1, 0.1)
    robot.press(True, {"arm_right_1_joint": 0.43})
    assert set(states(robot).values()) == {"stopped"}
    assert "emergency" in robot.command(row.topic, goal, 0.2, 0.2)
    robot.advance(0.5, 0.1)
    robot.press(False, {"arm_right_1_joint": 0.42})
    robot.advance(2.0, 0.1)
    assert robot.position["arm_right_1_joint"] == pytest.approx(0.42)
    assert states(robot)[ARM] == "running"


def test_the_base_goes_within_its_limits_and_halts_by_itself() -> None:
    base, step = BaseController(BASES["differential"]), 0.01
    assert base.command(np.array((0.3, 0.5, 0.0)), 0.0) == ""
    speeds = [base.advance(step * i, step) for i in range(100)]
    assert max(speed[0] for speed in speeds) == pytest.approx(COMMAND_TIMEOUT, abs=0.02), "1 m/s2 until the time-out"
    assert not any(speed[1] for speed in speeds)
    assert not speeds[-1].any()


def test_a_stamped_command_counts_from_its_stamp() -> None:
    base = BaseController(BASES["omni"])
    assert "over the time-out" in base.command(np.ones(3), 10.0, stamp=9.0)
    assert base.command(np.array((0.1, 0.0, 0.0)), 10.0, stamp=9.9) == ""
    assert base.advance(10.1, 0.05)[0] > 0.0
    assert base.advance(10.2, 0.05)[0] == pytest.approx(0.0)


def test_a_base_takes_no_velocity_that_is_no_number() -> None:
    assert BaseController(BASES["omni"]).command(np.array((np.nan, 0.0, 0.0)), 0.0) != ""
