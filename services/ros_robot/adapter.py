"""What joins the simulated robot to a middleware.

A module for each transport has a function ``connect(robot, address)`` that returns an ``Adapter`` at once, whether
there is anybody to connect to or not, and raises ``Refused`` for an address or an installation that cannot work.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Protocol

from services.ros_robot.messages import Publication
from services.ros_robot.robot import RosRobot

MODULES = {
    "ros1": "services.ros_robot.ros1",
    "rmw_zenoh": "services.ros_robot.rmw_zenoh",
    "dds": "services.ros_robot.dds",
}
"""Module of each transport."""


class Adapter(Protocol):
    """Carries the robot's topics and services over a middleware."""

    def publish(self, publications: Sequence[Publication]) -> None:
        """Send what a tick yields; it never waits, and never raises for what the network does."""
        ...

    def watched(self) -> bool:
        """Whether anybody subscribes to the camera's images."""
        ...

    def notes(self) -> str:
        """What people should know, such as that the middleware is away; empty if there is nothing."""
        ...

    def close(self) -> None:
        """Leave the network."""
        ...


class Unconnected:
    """No middleware: the world alone."""

    def publish(self, publications: Sequence[Publication]) -> None:
        """Nobody hears them."""

    def watched(self) -> bool:
        """Nobody does."""
        return False

    def notes(self) -> str:
        """Nothing: it was asked for."""
        return ""

    def close(self) -> None:
        """There is nothing to leave."""


def connect(robot: RosRobot, transport: str, address: str) -> Adapter:
    """An adapter for a transport.

    Raises:
        Refused: the address or the installation cannot work; one line.
    """
    if transport == "none":
        return Unconnected()
    adapter: Adapter = importlib.import_module(MODULES[transport]).connect(robot, address)
    return adapter
