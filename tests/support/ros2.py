"""ROS 2 for tests: a simulated TIAGo with a Zenoh network of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from tests.support.ports import free_endpoint
from tests.support.processes import Process

_FAR: dict[str, str] = {}


def robot(start: Callable[..., Process], endpoint: str, name: str = "tiago") -> Mapping[str, str]:
    """Starts a simulated TIAGo under ROS 2 with rmw_zenoh, whose world is on the bus of a router.

    Args:
        start: starts a process.
        endpoint: of the router.
        name: of the robot to which the world belongs on that bus; another one than the bridge's keeps to itself.

    Returns:
        The environment of whoever is to find it; a robot that is there already stays.
    """
    far = _FAR.setdefault(endpoint, free_endpoint())
    # Without a panel and at its least rate: the robot has to keep its pace on a slow machine.
    settings = ('profile="tiago-ros2"', 'scene="load"', "control_rate=100.0", f'address="{far}"')
    start("services.ros_robot", "--robot", name, "--connect", endpoint, *(f"--set={setting}" for setting in settings))
    return {"TANDEM_FAR": far}
