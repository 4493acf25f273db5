"""The robot's names and numbers: those of the published TIAGo, as its description has them."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from shared.robot.tiago import (
    CAMERA_FRAME,
    CHAIN,
    FINGERS,
    GRIPPER_RANGES,
    HEAD,
    HEAD_RANGES,
    JOINTS,
    SENSOR_FRAME,
    SENSOR_JOINT,
    TOOL_FRAME,
    URDF,
)

ARM = (  # lower, upper [rad], velocity [rad/s], effort [Nm]
    (-1.1781, 1.5708, 1.95, 43),
    (-1.1781, 1.5708, 1.95, 43),
    (-0.7854, 3.9270, 2.35, 26),
    (-0.3927, 2.3562, 2.35, 26),
    (-2.0944, 2.0944, 1.95, 3),
    (-1.4137, 1.4137, 1.76, 6.6),
    (-2.0944, 2.0944, 1.76, 6.6),
)


def test_limits_are_those_of_the_tiago() -> None:
    wanted = {f"arm_{side}_{i + 1}_joint": row for side in ("left", "right") for i, row in enumerate(ARM)}
    wanted["torso_lift_joint"] = (0, 0.35, 0.07, 2000)
    wanted["head_1_joint"] = (-1.309, 1.309, 3.0, 5.197)
    wanted["head_2_joint"] = (-1.047, 0.785, 3.0, 2.77)
    for gripper in ("left", "right"):
        for finger in ("left", "right"):
            wanted[f"gripper_{gripper}_{finger}_finger_joint"] = (0, 0.045, 0.05, 16)
    assert wanted == JOINTS


def test_what_gripper_and_head_can_be_asked_for_follows_from_them() -> None:
    assert GRIPPER_RANGES == {"opening": (0.0, 0.09), "effort": (0.0, 16.0)}
    assert HEAD_RANGES == {"pan": (-1.309, 1.309), "tilt": (-1.047, 0.785)}


def test_every_name_stands_in_the_description() -> None:
    robot = ET.parse(URDF).getroot()
    links, joints = ({part.attrib["name"] for part in robot.iter(kind)} for kind in ("link", "joint"))
    assert {TOOL_FRAME, SENSOR_FRAME, CAMERA_FRAME} <= links
    assert {SENSOR_JOINT} <= joints and {*CHAIN, *HEAD, *FINGERS} <= set(JOINTS)
