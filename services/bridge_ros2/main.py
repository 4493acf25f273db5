"""The bridge to a robot under ROS 2, as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.bridge_ros2.parameters import BridgeRos2Parameters
from services.bridge_ros2.robot import Ros2Robot
from shared.loop.process import run
from shared.robot.bridge.bridge import Bridge


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    return run(lambda parameters: Bridge(parameters, Ros2Robot), BridgeRos2Parameters, "bridge_ros2", arguments)
