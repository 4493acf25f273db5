"""ROS 2 for tests: a simulated TIAGo with a Zenoh network of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from tests.support.ports import free_port
from tests.support.processes import Process
from tests.support.ros1 import LEAST

_FAR: dict[str, str] = {}


def robot(
    start: Callable[..., Process], endpoint: str, name: str = "tiago", host: str = "127.0.0.1", rate: float = LEAST
) -> Mapping[str, str]:
    """Starts a simulated TIAGo under ROS 2 with rmw_zenoh, whose world is on the bus of a router.

    Args:
        start: starts a process.
        endpoint: of the router.
        name: of the robot to which the world belongs on that bus; another one than the bridge's keeps to itself.
        host: address of this machine by which others reach it.
        rate: of its controllers [Hz]; the default is right where their share of the delay does not matter.

    Returns:
        The environment of whoever is to find it; a robot that is there already stays.
    """
    far = _FAR.setdefault(endpoint, f"tcp/{host}:{free_port()}")
    # Without a panel: the robot has to keep its pace on a slow machine.
    settings = ('profile="tiago-ros2"', 'scene="load"', f"control_rate={rate}", f'address="{far}"')
    start("services.ros_robot", "--robot", name, "--connect", endpoint, *(f"--set={setting}" for setting in settings))
    return {"TANDEM_FAR": far}
