"""A robot under ROS 1 as the bridge meets it, in a process of its own, and a rospy node that plays that robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from services.bridge_ros1.robot import Ros1Robot
from shared.robot.far_side import TrajectoryPoint
from shared.robot.profile import Profile
from tests.support.elsewhere import Elsewhere
from tests.support.ros1 import Ros, RosNode
from tests.support.wait import eventually

JOINTS, WRENCH, ODOMETRY, STOP = (
    "/joint_states",
    "/wrist_right_ft",
    "/mobile_base_controller/odom",
    "/power/is_emergency",
)
ARM, BASE, IMAGE, INFO = (
    "/arm_right_controller/command",
    "/servoing_cmd_vel",
    "/xtion/rgb/image_raw",
    "/xtion/rgb/camera_info",
)
ARM_JOINTS = Profile.load("tiago-ros1").controllers["arm"].joints
RUNNING = {row.controller: "running" for row in Profile.load("tiago-ros1").controllers.values()}
RIVAL = "arm_right_forward_velocity_controller"
SWITCHED = RUNNING | {"arm_right_controller": "stopped", RIVAL: "running"}


class Spoilt(Ros1Robot):
    """A robot to which something can be sent that no check has seen."""

    def spoil(self) -> None:
        """Send a trajectory with a number missing."""
        from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

        self._outlets[ARM].send(JointTrajectory(points=[JointTrajectoryPoint(positions=[1.0, None])]))

    def end_node(self) -> None:
        """What `rosnode kill` does."""
        import rospy

        rospy.signal_shutdown("asked")

    def handlers(self) -> tuple[int, int]:
        """Level of the root logger, and how many handlers it has."""
        import logging

        return logging.getLogger().level, len(logging.getLogger().handlers)


def bridge(ros: Ros, read_only: bool = False, ports: int = 0) -> Elsewhere[Ros1Robot]:
    return ros.start(Spoilt, Profile.load("tiago-ros1"), read_only, "", ports)


def robot_node(
    ros: Ros, states: Mapping[str, str] = RUNNING, newest: bool = True, answer: str = "ok"
) -> Elsewhere[RosNode]:
    """A node that says and hears what a TIAGo does."""
    node = ros.node("robot")
    for topic, kind in Profile.load("tiago-ros1").heard().items():
        node.advertise(topic, kind, topic == STOP)
    for topic, kind in Profile.load("tiago-ros1").commanded().items():
        node.subscribe(topic, kind)
    node.publish(STOP, {"data": False})
    node.manage(states, newest, answer)
    return node


def ready(robot: Elsewhere[Ros1Robot]) -> None:
    eventually(
        lambda: robot.ready() == "" and not robot.mismatches(), 20.0, lambda: f"{robot.ready()}; {robot.mismatches()}"
    )


def move(robot: Elsewhere[Ros1Robot], position: float = 0.1) -> None:
    robot.move(
        "arm",
        [
            TrajectoryPoint(0.1, np.full(7, position), np.full(7, 0.2)),
            TrajectoryPoint(0.2, np.full(7, position), np.zeros(7)),
        ],
    )


def says_joints(node: Elsewhere[RosNode], *position: float) -> Callable[[], None]:
    return lambda: node.publish(JOINTS, {"name": list("abc")[: len(position)], "position": list(position)})


def repeated(say: Callable[[], Any], until: Callable[[], Any], message: str) -> Any:
    """Say something again and again until something is so."""

    def turn() -> Any:
        say()
        return until()

    return eventually(turn, 20.0, message, every=0.05)
