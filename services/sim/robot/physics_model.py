"""The physics engine's view of the robot: few rigid bodies, so that a step is cheap.

Joints that are not driven are locked and everything rigidly connected is lumped into one body; only the fixed joint of
the force-torque sensor is kept, because its reaction is what the sensor reads. A step of this model takes a fifth of
one of the full robot's.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from services.sim.robot.kinematics import locked_except
from shared.robot.tiago import CHAIN, SENSOR_JOINT, URDF
from shared.spatial import rpy_from_rotation

ROTOR = 0.005
"""[kg m2] Inertia of the wrist's rotors as their gears reflect it: one of 5e-7 kg m2 behind a gear of 100. Without it
the hand would be so light that a joint whose motor gives way shakes in steps of 2 ms, held panel or not."""
ROTORS = CHAIN[-3:]
"""Joints that have a rotor here. Nobody publishes those of the joints above, and there they are little beside the
arm."""

_KIND = {"JointModelPZ": "prismatic", "JointModelRZ": "revolute"}


def lumped_model() -> pin.Model:
    """The chain to the tool with the sensor's joint as one more joint, so that the bodies end there."""
    text = URDF.read_text(encoding="utf-8").replace(
        f'<joint name="{SENSOR_JOINT}" type="fixed">',
        f'<joint name="{SENSOR_JOINT}" type="revolute"><limit lower="0" upper="0" velocity="0" effort="0"/>'
        '<axis xyz="0 0 1"/>',
    )
    model = pin.buildModelFromXML(text)
    return locked_except(model, (*CHAIN, SENSOR_JOINT))


def physics_urdf() -> str:
    """URDF text of the lumped robot: a link per joint, named like it; ``SENSOR_JOINT`` is fixed, the rest move."""
    model = lumped_model()
    robot = ET.Element("robot", name="tiago_lumped")
    _link(robot, "base_footprint", pin.Inertia.Zero())
    for index in range(1, model.njoints):
        name = model.names[index]
        _link(robot, name, _with_rotor(model.inertias[index]) if name in ROTORS else model.inertias[index])
        kind = "fixed" if name == SENSOR_JOINT else _KIND[model.joints[index].shortname()]
        joint = ET.SubElement(robot, "joint", name=name, type=kind)
        parent = model.parents[index]
        ET.SubElement(joint, "parent", link="base_footprint" if parent == 0 else model.names[parent])
        ET.SubElement(joint, "child", link=name)
        place = model.jointPlacements[index]
        rpy = _numbers(rpy_from_rotation(place.rotation))
        ET.SubElement(joint, "origin", xyz=_numbers(place.translation), rpy=rpy)
        if kind != "fixed":
            ET.SubElement(joint, "axis", xyz="0 0 1")
            row = index - 1
            ET.SubElement(
                joint,
                "limit",
                lower=_numbers([model.lowerPositionLimit[row]]),
                upper=_numbers([model.upperPositionLimit[row]]),
                velocity=_numbers([model.velocityLimit[row]]),
                effort=_numbers([model.effortLimit[row]]),
            )
    return ET.tostring(robot, encoding="unicode")


def _with_rotor(inertia: pin.Inertia) -> pin.Inertia:
    # About all axes: the engine refuses a body that has more about one than about both others together.
    return pin.Inertia(inertia.mass, inertia.lever, inertia.inertia + ROTOR * np.eye(3))


def _link(robot: ET.Element, name: str, inertia: pin.Inertia) -> None:
    inertial = ET.SubElement(ET.SubElement(robot, "link", name=name), "inertial")
    ET.SubElement(inertial, "origin", xyz=_numbers(inertia.lever))
    ET.SubElement(inertial, "mass", value=_numbers([inertia.mass]))
    moments = inertia.inertia[np.triu_indices(3)]
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    entries = {key: _numbers([value]) for key, value in zip(names, moments, strict=True)}
    ET.SubElement(inertial, "inertia", entries)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
