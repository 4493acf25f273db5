"""TIAGo in names and numbers: what every robot process needs, simulated or real.

What the robot's description says is read from it. The rest is stated here; NOTICE names the sources.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from shared.robot.base_gate import BaseLimits
from shared.robot.description import Description
from shared.robot.held_command import Ranges
from shared.spatial import Array

URDF = Path(__file__).with_name("tiago.urdf")
"""The description: chain, limits, masses and simple shapes of the robot with two arms."""

TOOL_FRAME = "gripper_right_grasping_frame"
SENSOR_FRAME = "wrist_right_ft_link"
SENSOR_JOINT = "wrist_right_ft_joint"
CAMERA_FRAME = "xtion_rgb_optical_frame"

TORSO = "torso_lift_joint"
CHAIN = (TORSO, *(f"arm_right_{number}_joint" for number in range(1, 8)))
"""The joints that move the tool, from the base outwards."""
HEAD = ("head_1_joint", "head_2_joint")
"""Pan and tilt."""
FINGERS = ("gripper_right_left_finger_joint", "gripper_right_right_finger_joint")


JOINTS = Description.of(URDF).joints
"""Every joint that moves, by its name, in the order of the description."""

_, FINGER_TRAVEL, FINGER_SPEED, FINGER_EFFORT = JOINTS[FINGERS[0]]
"""Way [m] of each finger from closed to open, its largest speed [m/s], its largest force [N] of closing."""
GRIPPER_RANGES: Ranges = {"opening": (0.0, 2.0 * FINGER_TRAVEL), "effort": (0.0, FINGER_EFFORT)}
"""Ranges of a gripper command [m, N]."""
HEAD_RANGES: Ranges = {
    word: (JOINTS[joint].lower, JOINTS[joint].upper) for word, joint in zip(("pan", "tilt"), HEAD, strict=True)
}
"""Ranges of a head command [rad]."""

BASES = {
    "differential": BaseLimits(1.0, 0.2, 0.0, 2.09, 1.0, 2.09),
    "omni": BaseLimits(1.0, 1.0, 1.0, math.radians(80.0), 1.0, 2.09, {"xy": 0.7, "xz": 0.5, "yz": 0.5, "xyz": 0.4}),
}
"""Limits of the two bases that a TIAGo may have, by their type."""

SENSOR_RANGE: Array = np.array((290.0, 290.0, 580.0, 10.0, 10.0, 10.0))
"""Largest reading [N, Nm] per axis of the wrist's sensor: Schunk FTN-Mini-45, calibration SI-290-10."""
