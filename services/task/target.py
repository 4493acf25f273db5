"""Where the tool is wanted while carrying (carry 1), and while the panel is set down."""

from __future__ import annotations

import math

from services.task.geometry import QUARTER, Pose, roll_since

SNAP_BEYOND = math.radians(75.0)  # [rad] of roll since the grasp from which the target's roll is 90 degrees
LEEWAY = math.radians(2.0)
"""How far off 90 degrees [rad] the target leaves the roll alone: to press the last degree would take all that the small
limit about x allows, and leave nothing for the way down."""


def carrying_target(home: Pose, tool: Pose, height: float, fixed: bool) -> Pose:
    """The target's pose in base.

    x, y and yaw are those of ``home`` in base, to which the base brings the tool back. Pitch and roll are the tool's
    own, so that the person may tilt and turn the panel; from 15 to 2 degrees off a quarter turn the robot helps.

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
        quarter = math.copysign(QUARTER, turned)
        roll = home_roll + min(quarter + LEEWAY, max(quarter - LEEWAY, turned))
    return Pose.from_rpy((home.position[0], home.position[1], height), (roll, pitch, yaw))


def standing_target(place: Pose, tool: Pose, height: float) -> Pose:
    """The target's pose in base while the panel is set down.

    x, y and yaw stay where that began, pitch and roll are as the ground gives them: what presses against
    a panel that stands takes room in the limits that the way down needs.

    Args:
        place: the tool when the panel began to stand.
        tool: the tool now.
        height: of the target [m].
    """
    roll, pitch, _ = tool.rpy.tolist()
    return Pose.from_rpy((place.position[0], place.position[1], height), (roll, pitch, float(place.rpy[2])))
