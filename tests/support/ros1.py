"""ROS 1 for tests: a real master on a loopback port of its own, and rospy nodes that play a robot, each a process."""

from __future__ import annotations

import os
import socket
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any
from urllib.parse import urlsplit

import pytest

from services.bridge_ros1 import controller_manager as manager
from services.bridge_ros1.debian import MASTER, NEEDED, find_rospy
from services.bridge_ros1.names import message_class
from services.ros_robot.parameters import RosRobotParameters
from shared.parameters import Refused
from tests.support.elsewhere import Elsewhere
from tests.support.ports import free_port
from tests.support.processes import Process
from tests.support.wait import eventually


def wanted() -> None:
    """Skips the test where there is no rospy; with TANDEM_ROS1=required, as in .ci/run, it fails instead."""
    try:
        find_rospy(NEEDED | MASTER)
    except Refused as problem:
        (pytest.fail if os.environ.get("TANDEM_ROS1") == "required" else pytest.skip)(str(problem))


class RosMaster:
    """A master, in the process that makes it."""

    def __init__(self, port: int) -> None:
        wanted()
        import rosmaster.master

        self._master = rosmaster.master.Master(port)
        self._master.start()

    def up(self) -> bool:
        """Whether it runs."""
        return bool(self._master.ok())


class RosNode:
    """A node of a robot, in the process that makes it."""

    def __init__(self, name: str) -> None:
        wanted()
        import rospy

        rospy.init_node(name, argv=[name], disable_signals=True, disable_rosout=True)
        self._publishers: dict[str, Any] = {}
        self._received: dict[str, list[Any]] = defaultdict(list)
        self._controllers: dict[str, str] = {}
        self._kept: list[Any] = []
        self.switched: list[tuple[list[str], list[str]]] = []

    def advertise(self, topic: str, kind: str, latched: bool = False) -> None:
        """Publish on a topic from now on."""
        import rospy

        self._publishers[topic] = rospy.Publisher(topic, message_class(kind), queue_size=10, latch=latched)

    def publish(self, topic: str, fields: Mapping[str, Any]) -> None:
        """Say something: fields by dotted names, ``header.frame_id``."""
        message = self._publishers[topic].data_class()
        for path, value in fields.items():
            *way, last = path.split(".")
            inside = message
            for part in way:
                inside = getattr(inside, part)
            setattr(inside, last, value)
        self._publishers[topic].publish(message)

    def mute(self, topic: str) -> None:
        """Have the connections that there are bring nothing more, as after a cable was cut for long."""
        for connection in self._publishers[topic].impl.connections:
            connection.write_data = lambda _: True

    def heard_by(self, topic: str) -> int:
        """How many subscribers are connected to what it publishes."""
        return int(self._publishers[topic].get_num_connections())

    def subscribe(self, topic: str, kind: str) -> None:
        """Keep what is said on a topic."""
        import rospy

        def hear(message: Any) -> None:
            self._received[topic].append(told(message) | {"arrival": time.monotonic()})

        self._kept.append(rospy.Subscriber(topic, message_class(kind), hear, tcp_nodelay=True))

    def received(self, topic: str) -> list[Any]:
        """What was said on it so far, each with its arrival [s] by the machine's steady clock."""
        return list(self._received[topic])

    def manage(self, states: Mapping[str, str], newest: bool, answer: str = "ok") -> None:
        """Be the controller manager of controllers in some states; its ``answer`` is ok, no, or none ever."""
        import threading

        import rospy

        self._controllers = dict(states)
        row = 0 if newest else 1
        lists, switches = manager.service_class(manager.LISTS[row]), manager.service_class(manager.SWITCHES[row])
        state = lists._classes["controller_manager_msgs/ControllerState"]

        def listed(_: Any) -> Any:
            rows = [state(name=name, state=state_) for name, state_ in self._controllers.items()]
            return lists._response_class(controller=rows)

        def switch(request: Any) -> Any:
            if answer == "none":
                threading.Event().wait()
            if answer == "ok":
                self.switched.append((list(request.start_controllers), list(request.stop_controllers)))
                self._controllers |= dict.fromkeys(request.start_controllers, "running")
                self._controllers |= dict.fromkeys(request.stop_controllers, "stopped")
            return switches._response_class(ok=answer == "ok")

        self._kept += [
            rospy.Service("/controller_manager/list_controllers", lists, listed),
            rospy.Service("/controller_manager/switch_controller", switches, switch),
        ]

    def controllers(self) -> dict[str, str]:
        """States of the controllers by name."""
        return dict(self._controllers)


def told(message: Any) -> dict[str, Any]:
    """A message as plain data."""
    return {
        slot: told(value) if hasattr(value, "__slots__") and hasattr(value, "_type") else _plain(value)
        for slot in message.__slots__
        if (value := getattr(message, slot)) is not None
    }


def _plain(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [told(each) if hasattr(each, "_type") else each for each in value]
    return value.to_sec() if hasattr(value, "to_sec") else value


class Ros:
    """A master's address, and processes of nodes that end with the test.

    Attributes:
        uri: of the master.
    """

    def __init__(self) -> None:
        self.port = free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        self._all: list[Elsewhere[Any]] = []

    def start(self, make: Any, *arguments: Any) -> Elsewhere[Any]:
        """Something in a process of its own."""
        made = Elsewhere(make, *arguments)
        self._all.append(made)
        return made

    def master(self) -> Elsewhere[RosMaster]:
        """A master at the address."""
        master = self.start(RosMaster, self.port)
        assert master.up()
        return master

    def node(self, name: str) -> Elsewhere[RosNode]:
        """A node of the robot."""
        return self.start(RosNode, name)

    def close(self) -> None:
        """End all processes."""
        for each in reversed(self._all):
            each.__exit__()


LEAST = 100.0
"""[Hz] The least rate that a robot's controllers may have, on a machine with much else to do."""
USUAL: float = RosRobotParameters.model_fields["control_rate"].default  # [Hz]
_MASTERS: dict[str, str] = {}
_RUNNING: dict[str, Process] = {}
"""By endpoint: a second node of its name would have the master send the first one away."""


def robot(
    start: Callable[..., Process], endpoint: str, name: str = "tiago", host: str = "127.0.0.1", rate: float = LEAST
) -> Mapping[str, str]:
    """Starts a simulated TIAGo under ROS 1, with a master of its own, whose world is on the bus of a router.

    Args:
        start: starts a process.
        endpoint: of the router.
        name: of the robot to which the world belongs on that bus; another one than the bridge's keeps to itself.
        host: address of this machine by which others reach it.
        rate: of its controllers [Hz]; the default is right where their share of the delay does not matter.

    Returns:
        The environment of whoever is to find it; a robot that is there already stays.
    """
    wanted()
    uri = _MASTERS.setdefault(endpoint, f"http://{host}:{free_port()}")
    environment = {"ROS_MASTER_URI": uri, "ROS_IP": host}
    if endpoint not in _RUNNING or not _RUNNING[endpoint].running:
        # Without a panel: the robot has to keep its pace on a slow machine.
        options = ("--robot", name, "--connect", endpoint, '--set=scene="load"', f"--set=control_rate={rate}")
        _RUNNING[endpoint] = start("services.ros_robot", *options, environment=environment)
        # A node waits for its master in whatever starts it.
        eventually(lambda: _answers(uri), 60.0, f"a master at {uri}")
    return environment


def _answers(uri: str) -> bool:
    with suppress(OSError), socket.create_connection((urlsplit(uri).hostname, urlsplit(uri).port), 1.0):
        return True
    return False


def ros(monkeypatch: pytest.MonkeyPatch) -> Iterator[Ros]:
    """Body of a fixture: ROS on loopback, for this test alone."""
    wanted()
    made = Ros()
    monkeypatch.setenv("ROS_MASTER_URI", made.uri)
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    try:
        yield made
    finally:
        made.close()
