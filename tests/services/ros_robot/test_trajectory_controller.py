"""The joint trajectory controller does what those of ROS 1 and ROS 2 do, where it matters to a bridge."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from services.ros_robot.messages import Middleware, Point, Trajectory
from services.ros_robot.trajectory_controller import JointTrajectoryController

JOINTS = ("shoulder", "elbow")
START = np.array((0.0, 1.0))


def controller(middleware: Middleware = "ros1") -> JointTrajectoryController:
    made = JointTrajectoryController(middleware, "arm", JOINTS, START)
    made.running = True
    return made


def to(*points: tuple, joints: tuple[str, ...] = JOINTS) -> Trajectory:
    """Points as (after, position, velocity or nothing)."""
    return Trajectory(
        joints, tuple(Point(point[0], np.array(point[1]), *(np.array(v) for v in point[2:])) for point in points)
    )


def test_it_holds_the_start_until_something_is_commanded() -> None:
    position, velocity = controller().sample(3.0)
    assert position == pytest.approx(START) and not velocity.any()


def test_a_point_with_velocities_is_reached_by_a_cubic_from_the_present_set_point() -> None:
    arm = controller()
    assert arm.command(to((1.0, (1.0, 1.0), (0.0, 0.0))), 2.0, 2.0) == ""
    assert arm.sample(2.0)[0] == pytest.approx(START)
    position, velocity = arm.sample(2.5)
    assert position == pytest.approx((0.5, 1.0)) and velocity == pytest.approx((1.5, 0.0))
    assert arm.sample(3.0)[0] == pytest.approx((1.0, 1.0))


def test_the_last_point_is_held_at_rest_whatever_its_velocity() -> None:
    arm = controller()
    arm.command(to((1.0, (1.0, 1.0), (0.7, 0.0))), 0.0, 0.0)
    position, velocity = arm.sample(9.0)
    assert position == pytest.approx((1.0, 1.0)) and not velocity.any()


def test_without_velocities_the_way_is_straight() -> None:
    arm = controller()
    arm.command(to((2.0, (1.0, 0.0)), (3.0, (1.0, 0.5))), 0.0, 0.0)
    position, velocity = arm.sample(0.5)
    assert position == pytest.approx((0.25, 0.75)) and velocity == pytest.approx((0.5, -0.5))
    assert arm.sample(2.5)[0] == pytest.approx((1.0, 0.25))


def test_a_new_message_replaces_the_old_one_at_once_and_smoothly() -> None:
    arm = controller()
    arm.command(to((1.0, (1.0, 1.0), (0.0, 0.0))), 0.0, 0.0)
    before = arm.sample(0.5)
    arm.command(to((1.0, (0.0, 1.0), (0.0, 0.0))), 0.5, 0.5)
    after = arm.sample(0.5)
    assert after[0] == pytest.approx(before[0]) and after[1] == pytest.approx(before[1])
    assert arm.sample(1.5)[0] == pytest.approx(START)
    steps = [arm.sample(0.5 + 0.01 * i)[0][0] for i in range(101)]
    assert max(abs(b - a) for a, b in itertools.pairwise(steps)) < 0.03


def test_short_trajectories_that_end_at_rest_follow_a_speed_and_stop_when_they_cease() -> None:
    arm, speed = controller(), np.array((0.2, 0.0))
    for i in range(50):
        now = 0.02 * i
        ahead = START + speed * (now + 0.05)
        arm.command(to((0.05, ahead, speed), (0.15, ahead + 0.05 * speed, (0.0, 0.0))), now, now)
    assert arm.sample(1.0)[1] == pytest.approx(speed, abs=0.01)
    assert not arm.sample(1.15)[1].any()
    assert arm.sample(5.0)[0][0] == pytest.approx(0.2 * 1.08, abs=0.002)


def test_the_joints_come_in_any_order() -> None:
    arm = controller()
    assert arm.command(to((1.0, (0.3, 0.2)), joints=("elbow", "shoulder")), 0.0, 0.0) == ""
    assert arm.sample(1.0)[0] == pytest.approx((0.2, 0.3))


@pytest.mark.parametrize(
    ("message", "why"),
    [
        (to((1.0, (0.3,)), joints=("elbow",)), "missing: shoulder"),
        (to((1.0, (0.3, 0.1, 0.2)), joints=("elbow", "shoulder", "knee")), "strange: knee"),
        (to((1.0, (0.3, 0.1)), joints=("elbow", "elbow")), "missing: shoulder"),
        (to(), "no point"),
        (to((1.0, (0.3, 0.1)), (1.0, (0.4, 0.1))), "does not grow"),
        (to((1.0, (0.3, 0.1), (0.0,))), "2 finite numbers"),
        (to((1.0, (np.nan, 0.1))), "2 finite numbers"),
    ],
    ids=["too few", "too many", "twice", "empty", "time", "size", "nan"],
)
def test_what_is_refused_leaves_the_old_trajectory(message: Trajectory, why: str) -> None:
    arm = controller()
    arm.command(to((1.0, (1.0, 1.0))), 0.0, 0.0)
    assert why in arm.command(message, 0.2, 0.2)
    assert arm.sample(1.0)[0] == pytest.approx((1.0, 1.0))


def test_it_refuses_while_it_does_not_run() -> None:
    arm = controller()
    arm.running = False
    assert "not running" in arm.command(to((1.0, (1.0, 1.0))), 0.0, 0.0)


def test_a_point_of_now_is_dropped_by_ros1_and_jumped_to_by_ros2() -> None:
    message = to((0.0, (1.0, 1.0)))
    careful, jumpy = controller("ros1"), controller("ros2")
    assert "in the past" in careful.command(message, 5.0, 5.0)
    assert careful.sample(5.0)[0] == pytest.approx(START)
    assert jumpy.command(message, 5.0, 5.0) == ""
    assert jumpy.sample(5.0)[0] == pytest.approx((1.0, 1.0))


def test_a_trajectory_that_began_long_ago_goes_on_where_it_would_be() -> None:
    message = to((1.0, (1.0, 1.0)), (3.0, (3.0, 1.0)))
    careful, jumpy = controller("ros1"), controller("ros2")
    for arm in (careful, jumpy):
        assert arm.command(message, 2.0, 0.0) == ""
    assert careful.sample(2.0)[0] == pytest.approx(START)
    assert jumpy.sample(2.0)[0] == pytest.approx((2.0, 1.0))
    assert careful.sample(3.0)[0] == pytest.approx((3.0, 1.0))


@pytest.mark.parametrize("middleware", ["ros1", "ros2"])
def test_a_trajectory_that_begins_later_leaves_the_old_one_until_then(middleware: Middleware) -> None:
    arm = controller(middleware)
    arm.command(to((2.0, (1.0, 1.0))), 0.0, 0.0)
    assert arm.command(to((1.0, (0.0, 1.0))), 0.5, 1.0) == ""
    assert arm.sample(0.8)[0] == pytest.approx((0.4, 1.0))
    assert arm.sample(1.0)[0] == pytest.approx((0.5, 1.0))
    assert arm.sample(2.0)[0] == pytest.approx((0.0, 1.0))
