"""The parameters of the bridge to a robot under ROS 1."""

from __future__ import annotations

from shared.parameters import option, parameter
from shared.robot.bridge.parameters import BridgeParameters


class BridgeRos1Parameters(BridgeParameters):
    """Those of every bridge, and where the robot is."""

    master: str = option("", "address of the ROS master, http://robot:11311; ROS_MASTER_URI if empty")
    ports: int = parameter(
        0, "", 0, 65534, "first of the two at which the robot's nodes reach this one, through a wall; 0: any free ones"
    )
