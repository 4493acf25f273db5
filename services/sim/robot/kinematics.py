"""Postures in which the simulated TIAGo starts, and the kinematics of its torso and right arm."""

from __future__ import annotations

from collections.abc import Mapping

import pinocchio as pin

from shared.robot import kinematics
from shared.robot.kinematics import Kinematics, configuration
from shared.robot.tiago import CHAIN, SENSOR_FRAME, TOOL_FRAME, URDF
from shared.spatial import Array

HOME = {
    "torso_lift_joint": 0.345,
    "arm_right_1_joint": 0.66393062,
    "arm_right_2_joint": 1.07003071,
    "arm_right_3_joint": 1.02240766,
    "arm_right_4_joint": 2.3362,
    "arm_right_5_joint": 1.51284625,
    "arm_right_6_joint": 1.06685273,
    "arm_right_7_joint": 0.45070951,
    "arm_left_1_joint": 0.25,
    "arm_left_2_joint": 1.4,
    "arm_left_3_joint": 1.57,
    "arm_left_4_joint": 0.7,
    "arm_left_5_joint": 0.0,
    "arm_left_6_joint": 0.0,
    "arm_left_7_joint": 0.0,
    "head_1_joint": -0.45,
    "head_2_joint": -0.35,
}
"""Positions [m, rad] at the start; joints not named stand at zero.

The tool is at (0.5, -0.3, 1.0) m with the axes of the base. There the forearm's roll joint, which yields above 3 Nm,
decides what the arm can carry: with the elbow out to the side, where most solutions have it, a weight of 15 N at the
tool is too much. Here the elbow is low, the torso high and the elbow joint nearly closed, and 28 N at the tool take 2.5
of its 3 Nm. Going down only makes that easier.
"""

FULL_HOME = HOME | {"head_2_joint": -0.5}
"""The same with the head lowered a little, so that the whole marker on the panel is in the picture."""

CARRY_HOME = HOME | {
    "torso_lift_joint": 0.22344,
    "arm_right_1_joint": 0.09663,
    "arm_right_2_joint": 0.66368,
    "arm_right_3_joint": 1.70416,
    "arm_right_4_joint": 2.13967,
    "arm_right_5_joint": 1.25789,
    "arm_right_6_joint": 0.67047,
    "arm_right_7_joint": -0.40282,
}
"""The start in the carrying scenario: the tool at (0.45, -0.39, 0.78) m in front of the panel's edge, rolled by -90
degrees, so that the fingers are above and below the panel. From here the onboard inverse kinematics reaches x 0.45 to
0.6 m and z 0.3 to 1.05 m over the whole turn of the panel to roll 0, with yaw and pitch of 15 degrees.
"""


def full_model() -> pin.Model:
    """The whole robot on its fixed ``base_footprint``."""
    return kinematics.full_model(URDF)


def home(model: pin.Model, start: Mapping[str, float] = HOME) -> Array:
    """A start configuration [m, rad] in the order of the model's joints."""
    return configuration(model, start)


def locked_except(model: pin.Model, free: tuple[str, ...]) -> pin.Model:
    """The model with all joints but the ``free`` ones fixed at their start positions."""
    return kinematics.locked_except(model, free, HOME)


def arm_kinematics(start: Mapping[str, float] = HOME) -> Kinematics:
    """Kinematics of torso and right arm.

    Args:
        start: positions [m, rad] of the joints at the start, by name.
    """
    model = locked_except(full_model(), CHAIN)
    return Kinematics(model, TOOL_FRAME, SENSOR_FRAME, home(model, start))
