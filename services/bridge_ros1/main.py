"""The bridge to a robot under ROS 1 as a process."""

from __future__ import annotations

from collections.abc import Sequence

from services.bridge_ros1.parameters import BridgeRos1Parameters
from services.bridge_ros1.robot import Ros1Robot
from shared.loop.process import run
from shared.robot.bridge.bridge import Bridge
from shared.robot.profile import Profile


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    return run(lambda parameters: Bridge(parameters, _robot), BridgeRos1Parameters, "bridge_ros1", arguments)


def _robot(profile: Profile, parameters: BridgeRos1Parameters) -> Ros1Robot:
    return Ros1Robot(profile, parameters.read_only, parameters.master, parameters.ports)
