"""Where the tool is wanted while carrying (CARRY 1)."""

from __future__ import annotations

import math

from services.task.geometry import QUARTER, Pose, roll_since

SNAP_BEYOND = math.radians(75.0)
"""Roll since the grasp [rad] from which the target's is exactly 90 degrees."""


def carrying_target(home: Pose, tool: Pose, height: float, fixed: bool) -> Pose:
    """The target's pose in base.

    x, y and yaw are those of ``home`` in base axes, whence the base brings the tool back; pitch and roll are the tool's
    own, so that the person may tilt and turn the panel; the last 15 degrees to a quarter turn the robot helps.

    Args:
        home: the tool when the grasp was finished.
        tool: the tool now.
        height: of the target [m].
        fixed: the whole of ``home`` is the target, as in the paper.
    """
    if fixed:
        return home
    roll, pitch, _ = tool.rpy.tolist()
    home_roll, _, yaw = home.rpy.tolist()
    turned = roll_since(home, tool)
    if abs(turned) > SNAP_BEYOND:
        roll = home_roll + math.copysign(QUARTER, turned)
    return Pose.from_rpy((home.position[0], home.position[1], height), (roll, pitch, yaw))
