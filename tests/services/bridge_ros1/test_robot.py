"""A robot under ROS 1, against real rospy nodes and a real master: what is heard, sent and switched."""

from __future__ import annotations

import functools
import time

import numpy as np
import pytest

from shared.robot.far_side import TrajectoryPoint
from tests.services.bridge_ros1.rig import (
    ARM,
    ARM_JOINTS,
    BASE,
    IMAGE,
    INFO,
    JOINTS,
    ODOMETRY,
    RIVAL,
    SWITCHED,
    WRENCH,
    bridge,
    move,
    ready,
    repeated,
    robot_node,
    says_joints,
)
from tests.support.ros1 import Ros
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes


def test_what_the_robot_says_arrives_with_its_sender_and_stamp(ros: Ros) -> None:
    ros.master()
    node, robot = robot_node(ros), bridge(ros)
    ready(robot)
    heard = repeated(says_joints(node, 1.0, 2.0), robot.joints, "joint states arrive")
    assert heard.message.names == ("a", "b") and heard.message.position.tolist() == [1.0, 2.0]
    assert heard.sender == "/robot" and heard.stamp == 0
    assert 0 < time.monotonic_ns() - heard.arrival < 5e9
    wrench = {"header.frame_id": "wrist_right_ft_link", "wrench.force.z": -9.81, "wrench.torque.x": 0.5}
    heard = repeated(lambda: node.publish(WRENCH, wrench), robot.wrench, "a wrench arrives")
    assert heard.message.force.tolist() == [0.0, 0.0, -9.81] and heard.message.frame == "wrist_right_ft_link"
    base = {"pose.pose.orientation.w": 1.0, "twist.twist.linear.x": 0.3}
    heard = repeated(lambda: node.publish(ODOMETRY, base), robot.odometry, "odometry arrives")
    assert heard.message.velocity.tolist() == [0.3, 0.0, 0.0]
    assert robot.handlers() == (30, 0)


def test_what_is_not_finite_is_refused_and_the_last_good_one_stands(ros: Ros) -> None:
    ros.master()
    node, robot = robot_node(ros), bridge(ros)
    ready(robot)
    repeated(says_joints(node, 1.0), robot.joints, "joint states arrive")
    refusal = repeated(says_joints(node, float("inf")), lambda: robot.refusals().get(JOINTS), "it is refused")
    assert "position is not finite: element 0, from /robot" in refusal
    assert robot.joints().message.position.tolist() == [1.0]


def test_a_trajectory_and_a_twist_arrive_as_they_were_commanded(ros: Ros) -> None:
    ros.master()
    node, robot = robot_node(ros), bridge(ros)
    ready(robot)
    # What is said before the connection stands is lost.
    command = repeated(lambda: move(robot), lambda: node.received(ARM), "a trajectory arrives")[0]
    assert command["joint_names"] == list(ARM_JOINTS) and command["header"]["stamp"] == 0.0
    assert [point["time_from_start"] for point in command["points"]] == [0.1, 0.2]
    assert command["points"][1]["positions"] == [0.1] * 7 and command["points"][1]["velocities"] == [0.0] * 7
    drive = functools.partial(robot.drive, np.array((0.1, 0.0, -0.2)))
    command = repeated(drive, lambda: node.received(BASE), "a twist arrives")[0]
    assert command["linear"]["x"] == 0.1 and command["angular"]["z"] == -0.2


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ([TrajectoryPoint(0.1, np.full(7, np.nan), np.zeros(7))], "position is not finite"),
        ([TrajectoryPoint(0.1, np.zeros(6), np.zeros(6))], "wanted .7,."),
        ([TrajectoryPoint(0.0, np.zeros(7), np.zeros(7))], "more than 0 s"),
        ([TrajectoryPoint(0.1, np.zeros(7), np.ones(7))], "at rest"),
        ([], "at rest"),
    ],
)
def test_a_command_that_is_none_is_not_sent(points: list[TrajectoryPoint], why: str, ros: Ros) -> None:
    robot = bridge(ros)
    robot.move("arm", points)
    with pytest.raises(AssertionError, match=why):
        raise AssertionError(robot.refusals()[ARM])


def test_a_publisher_that_failed_is_made_anew_and_heard_again(ros: Ros) -> None:
    ros.master()
    node, robot = robot_node(ros), bridge(ros)
    ready(robot)
    repeated(robot.spoil, lambda: "not sent" in robot.refusals().get(ARM, ""), "its failure is told")
    repeated(
        lambda: move(robot, 0.7),
        lambda: [c for c in node.received(ARM) if c["points"][0]["positions"] == [0.7] * 7],
        "it is heard again",
    )


@pytest.mark.parametrize("newest", [True, False], ids=["noetic", "kinetic"])
def test_controllers_are_switched_in_and_back(newest: bool, ros: Ros) -> None:
    ros.master()
    node = robot_node(ros, SWITCHED, newest)
    robot = bridge(ros)
    ready(robot)
    assert node.controllers()["arm_right_controller"] == "running" and node.controllers()[RIVAL] == "stopped"
    robot.close()
    assert node.controllers()["arm_right_controller"] == "stopped" and node.controllers()[RIVAL] == "running"


def test_read_only_nothing_is_switched_or_sent(ros: Ros) -> None:
    ros.master()
    node = robot_node(ros, SWITCHED)
    robot = bridge(ros, True)
    eventually(lambda: robot.ready() == "the controller arm_right_controller is stopped", 20.0, robot.ready)
    move(robot)
    throughout(lambda: not node.received(ARM), 0.5)


@pytest.mark.parametrize(
    ("answer", "why"), [("no", "refuses to start arm_right_controller"), ("none", "has not answered for")]
)
def test_a_controller_manager_that_does_not_switch_is_named(answer: str, why: str, ros: Ros) -> None:
    ros.master()
    robot_node(ros, SWITCHED, answer=answer)
    robot = bridge(ros)
    eventually(lambda: why in robot.ready(), 20.0, robot.ready)


def test_the_camera_is_subscribed_to_while_it_is_wanted(ros: Ros) -> None:
    ros.master()
    node, robot = robot_node(ros), bridge(ros)
    ready(robot)
    assert node.heard_by(IMAGE) == 0

    def say() -> None:
        node.publish(IMAGE, {"width": 2, "height": 1, "step": 6, "encoding": "bgr8", "data": b"abcdef"})
        node.publish(
            INFO, {"width": 2, "height": 1, "K": [1.0, 0, 1, 0, 1, 1, 0, 0, 1], "distortion_model": "plumb_bob"}
        )

    picture, calibration = repeated(say, lambda: robot.picture(True), "an image arrives")
    assert picture.message.data == b"abcdef" and calibration.message.model == "plumb_bob"
    robot.picture(False)
    eventually(lambda: node.heard_by(IMAGE) == 0, 20.0, "it is let go of")
    assert robot.picture(False) is None
