"""The simulated robot under ROS 1: a node of a real master, which is started here if there is none on this machine."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Sequence
from typing import Any

from services.bridge_ros1 import controller_manager as manager
from services.bridge_ros1.commands import Outlet
from services.bridge_ros1.debian import MASTER, find_rospy
from services.bridge_ros1.master import Graph, Master, NoMaster
from services.bridge_ros1.node import Ear, Node
from services.ros_robot import ros1_messages as messages
from services.ros_robot.messages import Publication
from services.ros_robot.robot import RosRobot

NODE = "simulated_tiago"
"""Name of the node, in front of what makes it unique."""
CONTROLLER_MANAGER = "/controller_manager"
_REPLIES = {"list": manager.LISTS[0], "switch": manager.SWITCHES[0]}


def connect(robot: RosRobot, address: str) -> Ros1Adapter:
    """The robot at a master's address, or at that of ROS_MASTER_URI if it is empty.

    Raises:
        Refused: rospy is missing, or that is no address.
    """
    find_rospy()
    uri = address or os.environ.get("ROS_MASTER_URI", "http://localhost:11311")
    return Ros1Adapter(robot, Master(uri, f"/{NODE}"))


class Ros1Adapter:
    """Topics and services of a robot at a master; an ``Adapter``.

    A node left over is a second one for the master and whoever asks it: a process has no second one under rospy.
    """

    def __init__(self, robot: RosRobot, master: Master) -> None:
        self._robot, self._master = robot, master
        self._own_master = _start_master(master)
        ears = [Ear(topic, kind, self._taker(topic), shared=True) for topic, kind in robot.subscriptions.items()]
        self._outlets = {topic: Outlet(topic, kind) for topic, kind in robot.publications.items()}
        self._others: set[tuple[str, str]] = set()
        self._services: dict[str, Any] = {}
        self._node = Node(master, NODE, ears, list(self._outlets.values()), self._look, lambda: None)

    def publish(self, publications: Sequence[Publication]) -> None:
        for publication in publications:
            outlet = self._outlets[publication.topic]
            outlet.latched = publication.latched
            if publication.node != "robot":
                self._others.add((f"/{publication.node}", publication.topic))
            outlet.send(messages.written(publication))

    def watched(self) -> bool:
        return any(outlet.listeners for outlet in self._outlets.values() if outlet.kind.endswith("/Image"))

    def notes(self) -> str:
        return self._node.trouble

    def close(self) -> None:
        self._node.close()
        if self._own_master is not None:
            self._own_master.stop()

    def _taker(self, topic: str) -> Callable[[Any], None]:
        return lambda message: self._take(topic, message)

    def _take(self, topic: str, message: Any) -> None:
        self._robot.command(topic, messages.read(message))

    def _look(self, graph: Graph) -> None:
        import rospy

        own = rospy.get_node_uri()
        for caller, topic in self._others:
            if caller not in graph.publishers.get(topic, ()):
                Master(self._master.uri, caller).ask("registerPublisher", topic, self._outlets[topic].kind, own)
        for what, answer in (("list", self._list), ("switch", self._switch)):
            name = f"{CONTROLLER_MANAGER}/{what}_controller" + ("s" if what == "list" else "")
            if what not in self._services:
                self._services[what] = rospy.Service(name, manager.service_class(_REPLIES[what]), answer)
            elif name not in graph.services:
                self._master.ask("registerService", name, self._services[what].uri, own)

    def _list(self, _request: Any) -> Any:
        kind = manager.service_class(_REPLIES["list"])
        state = kind._classes["controller_manager_msgs/ControllerState"]
        resources = kind._classes["controller_manager_msgs/HardwareInterfaceResources"]
        return kind._response_class(
            controller=[
                state(
                    name=row.name,
                    state=row.state,
                    type=row.kind,
                    claimed_resources=[resources(resources=list(row.joints))],
                )
                for row in self._robot.listed()
            ]
        )

    def _switch(self, request: Any) -> Any:
        done = self._robot.switch(request.start_controllers, request.stop_controllers, request.strictness)
        return manager.service_class(_REPLIES["switch"])._response_class(ok=done)


def _start_master(master: Master) -> Any:
    """A master at an address of this machine where none answers; None for another machine's.

    Raises:
        Refused: it would have to be started, and its package is missing.
    """
    try:
        master.ask("getPid")
        return None
    except NoMaster:
        pass
    try:
        with socket.socket() as probe:
            probe.bind((socket.gethostbyname(master.host), 0))
    except OSError:
        return None
    find_rospy(MASTER)
    import rosmaster.master

    started = rosmaster.master.Master(master.port)
    started.start()
    return started
