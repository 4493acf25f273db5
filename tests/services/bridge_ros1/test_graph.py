"""A robot under ROS 1, against real rospy nodes and a real master: what is missing, wrong, or comes and goes."""

from __future__ import annotations

import signal
import socket
import time

import pytest

from tests.services.bridge_ros1.rig import (
    ARM,
    BASE,
    JOINTS,
    ODOMETRY,
    STOP,
    WRENCH,
    bridge,
    move,
    ready,
    repeated,
    robot_node,
    says_joints,
)
from tests.support.ports import free_pair
from tests.support.ros1 import Ros
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes


def test_the_emergency_stop_is_pressed_as_long_as_any_publisher_says_so(ros: Ros) -> None:
    ros.master()
    node, robot = robot_node(ros), bridge(ros)
    other = ros.node("power")
    other.advertise(STOP, "std_msgs/Bool", True)
    other.publish(STOP, {"data": True})
    eventually(lambda: robot.emergency() == "/power", 20.0, "it is pressed")
    node.publish(STOP, {"data": False})
    throughout(lambda: robot.emergency() == "/power", 0.5, "another one's word does not release it")
    other.publish(STOP, {"data": False})
    eventually(lambda: robot.emergency() == "", 20.0, "it is released")
    other.publish(STOP, {"data": True})
    eventually(lambda: robot.emergency() == "/power", 20.0, "it is pressed again")
    other.kill()
    throughout(lambda: robot.emergency() == "/power", 1.5, "its publisher's end does not release it")


def test_without_anybody_who_tells_of_the_emergency_stop_nothing_is_ready(ros: Ros) -> None:
    ros.master()
    robot = bridge(ros)
    eventually(lambda: f"nothing publishes {STOP}" in robot.ready(), 20.0, robot.ready)


def test_a_master_that_is_absent_is_named_and_waited_for(ros: Ros) -> None:
    robot = bridge(ros)
    eventually(lambda: f"no ROS master answers at {ros.uri}" in robot.ready(), 20.0, robot.ready)
    ros.master()
    robot_node(ros)
    ready(robot)


def test_a_master_that_restarts_is_told_again_of_everything(ros: Ros) -> None:
    master, robot = ros.master(), bridge(ros)
    old = robot_node(ros)
    ready(robot)
    master.kill()
    eventually(lambda: "no ROS master answers" in "".join(robot.mismatches()), 20.0, "its end is named")
    number = repeated(says_joints(old, 1.0), robot.joints, "what is connected goes on without it").number
    repeated(says_joints(old, 1.0), lambda: robot.joints().number > number + 3, "what is connected goes on without it")
    assert robot.ready() == ""
    old.kill()
    ros.master()
    new = robot_node(ros)
    repeated(says_joints(new, 2.0), lambda: robot.joints().message.position.tolist() == [2.0], "the new one is heard")
    repeated(lambda: move(robot), lambda: new.received(ARM), "the new one hears")
    ready(robot)


def test_what_the_topics_lack_is_named(ros: Ros) -> None:
    ros.master()
    robot, node = bridge(ros), ros.node("robot")
    node.advertise(JOINTS, "std_msgs/Bool")
    node.subscribe(ARM, "std_msgs/Bool")
    node.advertise(WRENCH, "geometry_msgs/WrenchStamped")
    other = ros.node("leftover")
    other.advertise(WRENCH, "geometry_msgs/WrenchStamped")
    wanted = (
        f"{JOINTS} is std_msgs/Bool on the robot (/robot), the profile says sensor_msgs/JointState",
        f"{WRENCH} has 2 publishers, /leftover and /robot",
        f"nobody publishes {ODOMETRY} (nav_msgs/Odometry)",
        f"nobody listens to {BASE} (geometry_msgs/Twist)",
    )
    eventually(
        lambda: all(line in "\n".join(robot.mismatches()) for line in wanted),
        20.0,
        lambda: "\n".join(robot.mismatches()),
    )
    eventually(
        lambda: (
            f"{ARM} is std_msgs/Bool" in "\n".join(robot.mismatches())
            or f"/robot listens to {ARM}, but has not connected" in "\n".join(robot.mismatches())
        ),
        20.0,
        lambda: "\n".join(robot.mismatches()),
    )


def test_somebody_else_who_commands_the_robot_is_named(ros: Ros) -> None:
    ros.master()
    robot_node(ros)
    robot, other = bridge(ros), ros.node("joystick")
    other.advertise(BASE, "geometry_msgs/Twist")
    eventually(
        lambda: f"{BASE} is commanded by /joystick, too" in robot.mismatches(),
        20.0,
        lambda: "\n".join(robot.mismatches()),
    )


def test_a_node_that_somebody_shuts_down_says_so(ros: Ros) -> None:
    ros.master()
    robot_node(ros)
    robot = bridge(ros)
    ready(robot)
    robot.end_node()
    eventually(lambda: "start the bridge again" in "".join(robot.mismatches()), 20.0, robot.mismatches)


def test_it_leaves_in_time_although_the_master_hangs(ros: Ros) -> None:
    master, robot = ros.master(), bridge(ros)
    robot_node(ros)
    ready(robot)
    master.signal(signal.SIGSTOP)
    before = time.monotonic()
    robot.close()
    assert time.monotonic() - before < 1.5


def test_nodes_of_the_robot_reach_it_at_the_ports_that_it_was_given(ros: Ros) -> None:
    ros.master()
    node, ports = robot_node(ros), free_pair()
    robot = bridge(ros, ports=ports)
    ready(robot)
    # Again: a connection may be made only after a command was told.
    repeated(lambda: move(robot), lambda: node.received(ARM), "a command arrives")
    for port in (ports, ports + 1):
        socket.create_connection(("127.0.0.1", port), 5.0).close()


def test_a_connection_that_brings_nothing_any_more_is_made_anew(ros: Ros) -> None:
    ros.master()
    node = robot_node(ros)
    robot = bridge(ros)
    repeated(says_joints(node, 1.0), robot.joints, "it is heard")
    node.mute(JOINTS)
    repeated(says_joints(node, 2.0), lambda: robot.joints().message.position[0] == 2.0, "it is heard again")
