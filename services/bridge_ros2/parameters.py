"""Parameters of the bridge to a robot under ROS 2."""

from __future__ import annotations

import os
from typing import Literal

from services.bridge_ros2 import codec
from services.bridge_ros2.names import HASHLESS, Dialect, RmwZenoh, Ros2Dds
from shared.parameters import Refused, option, parameter
from shared.robot.bridge.parameters import BridgeParameters

USUAL = "tcp/127.0.0.1:7448"
"""Endpoint of a robot on this machine: the next port to the router's of the project's own bus."""


class BridgeRos2Parameters(BridgeParameters):
    """Where the robot is, and how its topics travel, besides what every bridge has."""

    profile: str = option("tiago-ros2", "of the robot: the name of one that is shipped, or the path of a .toml file")
    far: str = option(
        "", f"endpoint of the robot's own Zenoh, a bridge's or router's; TANDEM_FAR if empty, else {USUAL}"
    )
    dialect: Literal["ros2dds", "rmw_zenoh"] = option(
        "ros2dds", "ros2dds: the robot is under DDS, with zenoh-bridge-ros2dds; rmw_zenoh: its RMW is rmw_zenoh_cpp"
    )
    domain: int = parameter(0, "", 0, 232, "ROS_DOMAIN_ID of the robot, for rmw_zenoh")
    distribution: Literal["humble", "jazzy"] = option("humble", "release of ROS 2: humble has no type hashes")
    namespace: str = option("", "that zenoh-bridge-ros2dds is configured to put in front of the topics, /robot1")

    def check(self) -> None:
        """Whether what is told belongs to the dialect.

        Raises:
            Refused: it does not.
        """
        super().check()
        if self.namespace and self.dialect != "ros2dds":
            raise Refused(f"namespace is {self.namespace}: under {self.dialect} topics have none but their own")

    @property
    def endpoint(self) -> str:
        """Endpoint of the robot's own Zenoh."""
        return self.far or os.environ.get("TANDEM_FAR") or USUAL

    def named(self) -> Dialect:
        """How topics are named on the robot's network."""
        if self.dialect == "ros2dds":
            return Ros2Dds(self.namespace)
        return RmwZenoh(self.domain, self.hash_of)

    def hash_of(self, kind: str) -> str:
        """Hash of a type, in that release."""
        return HASHLESS if self.distribution == "humble" else codec.type_hash(kind)
