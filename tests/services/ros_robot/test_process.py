"""The robot as a service: its topics go to the adapter, and its world is on the project's bus."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from services.ros_robot.adapter import Unconnected, connect
from services.ros_robot.messages import Publication, Twist
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.process import RosRobotService
from services.ros_robot.robot import RosRobot
from shared.loop.stack import Stack
from shared.parameters import Refused
from shared.robot.profile import Profile
from shared.sim_messages import SimWorld
from shared.topics import SIM_COMMAND, SIM_WORLD


class Kept(Unconnected):
    """An adapter that keeps what it is to send."""

    def __init__(self) -> None:
        self.sent: list[Publication] = []

    def publish(self, publications: Sequence[Publication]) -> None:
        self.sent += publications


def test_topics_go_to_the_adapter_and_the_world_to_the_bus() -> None:
    stack, adapter = Stack(), Kept()
    parameters = RosRobotParameters.of({"scene": "load", "mistakes": ["clock"]})
    robot = RosRobot(Profile.load("tiago-ros1"), parameters)
    service = RosRobotService(parameters, robot, adapter)
    stack.add(service)
    told: list[SimWorld] = []
    stack.client.watch(SIM_WORLD, lambda received: told.append(received.message))
    stack.run(1.0)
    assert len(told) == pytest.approx(30, abs=2)
    assert sum(one.topic == "/joint_states" for one in adapter.sent) == pytest.approx(50, abs=2)
    assert stack.client.ask(SIM_COMMAND, {"command": "load", "mass": 1.0})["ok"]
    stack.run(0.2)
    assert told[-1].bag is not None and told[-1].bag.mass == 1.0
    with pytest.raises(Refused, match="no panel"):
        stack.client.ask(SIM_COMMAND, {"command": "hand", "script": "carry"})
    robot.command("/joy_vel", Twist(np.zeros(3)))
    robot.command("/nav_vel", Twist(np.zeros(3)))
    assert service.notes() == (
        "planted: clock; /nav_vel: 1 commands without effect, the last: twist_mux: another source has priority"
    )


def test_a_transport_of_the_other_ros_is_refused() -> None:
    assert RosRobotParameters().transport_of("ros1") == "ros1"
    assert RosRobotParameters(transport="none").transport_of("ros2") == "none"
    assert RosRobotParameters(transport="dds").transport_of("ros2") == "dds"
    with pytest.raises(Refused, match="wanted rmw_zenoh or dds"):
        RosRobotParameters(transport="ros1").transport_of("ros2")
    assert isinstance(connect(RosRobot(Profile.load("tiago-ros1"), RosRobotParameters()), "none", ""), Unconnected)
