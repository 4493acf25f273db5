"""A robot under ROS 2 with DDS for tests: a domain of its own on this machine, and the real zenoh-bridge-ros2dds in it.

`make ros2dds` builds that program; TANDEM_ROS2DDS names another one, such as a released one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from services.ros_robot.dds import LOOPBACK
from tests.support.dds import free_domain
from tests.support.ports import free_endpoint
from tests.support.processes import ROOT, Process

BUILT = ROOT / "build" / "ros2dds" / "release" / "zenoh-bridge-ros2dds"


def find() -> Path:
    """Where the program is, or would be."""
    named = os.environ.get("TANDEM_ROS2DDS", "")
    return BUILT if named in ("", "required") else Path(named)


def program() -> Path:
    """The program; skips the test where there is none, with TANDEM_ROS2DDS, such as "required", it fails instead."""
    path = find()
    if not path.is_file():
        refuse = pytest.fail if os.environ.get("TANDEM_ROS2DDS") else pytest.skip
        refuse(f"there is no {path}: `make ros2dds` builds zenoh-bridge-ros2dds")
    return path


def bridge(
    start: Callable[..., Process], folder: Path, domain: int, endpoint: str = "", namespace: str = ""
) -> tuple[Process, str]:
    """Starts the program between a domain of DDS and Zenoh.

    Args:
        start: starts a process.
        folder: to which its settings are written.
        domain: by its number.
        endpoint: that it listens at; a free one if empty.
        namespace: that it puts in front of all topics, ``/robot1``.

    Returns:
        Its process, and its endpoint.
    """
    endpoint = endpoint or free_endpoint()
    settings = {
        "mode": "router",
        "listen": {"endpoints": [endpoint]},
        "scouting": {"multicast": {"enabled": False}},
        "plugins": {"ros2dds": {"domain": domain, **({"namespace": namespace} if namespace else {})}},
    }
    path = folder / f"ros2dds-{domain}.json5"
    path.write_text(json.dumps(settings), encoding="utf-8")
    environment = {"ROS_DISTRO": "humble", "CYCLONEDDS_URI": LOOPBACK}
    return start(str(program()), "-c", str(path), python="", environment=environment), endpoint


def robot(start: Callable[..., Process], folder: Path, endpoint: str, rate: float) -> Mapping[str, str]:
    """Starts a simulated TIAGo under DDS, whose world is on the bus of a router, and the program before it.

    Args:
        start: starts a process.
        folder: to which settings are written.
        endpoint: of the router.
        rate: of its controllers [Hz].

    Returns:
        The environment of whoever is to find it.
    """
    domain = free_domain()
    _, far = bridge(start, folder, domain)
    settings = (
        'profile="tiago-ros2"',
        'scene="load"',
        'transport="dds"',
        f'address="{domain}"',
        f"control_rate={rate}",
    )
    start("services.ros_robot", "--connect", endpoint, *(f"--set={setting}" for setting in settings))
    return {"TANDEM_FAR": far}
