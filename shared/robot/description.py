"""What a robot's description (URDF) says by itself: frames, joints and their limits, and what hangs together.

Read as the XML that it is: whoever only wants names and limits needs no library for kinematics.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

MOVING = ("revolute", "continuous", "prismatic")


class Undescribed(Exception):
    """The description cannot be read, or lacks something; the text is one line for the user."""


class Joint(NamedTuple):
    """Limits of a joint: positions [m, rad], speed [m/s, rad/s] and effort [N, Nm]."""

    lower: float
    upper: float
    velocity: float
    effort: float


class _Edge(NamedTuple):
    """A joint between two links."""

    name: str
    kind: str
    parent: str


@dataclass(frozen=True)
class Description:
    """A robot's description.

    Attributes:
        root: the link that no joint carries.
        joints: every joint that moves, by its name, in the order of the description.
    """

    root: str
    joints: Mapping[str, Joint]
    _masses: Mapping[str, float]
    _edges: Mapping[str, _Edge]

    @classmethod
    def of(cls, path: Path) -> Description:
        """The description in a file.

        Raises:
            Undescribed: it cannot be read, or is no tree of links and joints with limits.
        """
        try:
            robot = ET.parse(path).getroot()
        except OSError as problem:
            raise Undescribed(f"{path}: {problem.strerror}") from None
        except ET.ParseError as problem:
            raise Undescribed(f"{path}: not XML ({problem})") from None
        try:
            joints = {part.attrib["name"]: _joint(part) for part in robot.iter("joint") if part.get("type") in MOVING}
            masses = {part.attrib["name"]: _mass(part) for part in robot.iter("link")}
            edges = dict(_edge(part) for part in robot.iter("joint") if part.find("child") is not None)
        except (KeyError, ValueError, AttributeError) as problem:
            raise Undescribed(f"{path}: no valid URDF ({problem})") from None
        roots = [link for link in masses if link not in edges]
        if len(roots) != 1:
            raise Undescribed(f"{path}: {len(roots)} links are carried by no joint, wanted one, the robot's root")
        return cls(roots[0], joints, masses, edges)

    def has_frame(self, name: str) -> bool:
        """Whether there is a link of that name: every link has a frame."""
        return name in self._masses

    def chain(self, frame: str) -> tuple[str, ...]:
        """The joints that move a frame, from the root outwards."""
        names: list[str] = []
        while (edge := self._edges.get(frame)) is not None and len(names) <= len(self._edges):
            if edge.kind != "fixed":
                names.append(edge.name)
            frame = edge.parent
        return tuple(reversed(names))

    def carries(self, inner: str, outer: str) -> bool:
        """Whether a frame carries another one: nothing of what lies between the two leads round it."""
        while outer != inner and outer in self._edges:
            outer = self._edges[outer].parent
        return outer == inner

    def mass_beyond(self, frame: str) -> float:
        """Mass [kg] of the links that a frame's link carries, its own included."""
        return sum(mass for link, mass in self._masses.items() if self.carries(frame, link))


def _edge(joint: ET.Element) -> tuple[str, _Edge]:
    parent, child = joint.find("parent"), joint.find("child")
    assert child is not None
    if parent is None:
        raise KeyError(f"parent of {joint.attrib['name']}")
    return child.attrib["link"], _Edge(joint.attrib["name"], joint.attrib["type"], parent.attrib["link"])


def _mass(link: ET.Element) -> float:
    mass = link.find("inertial/mass")
    return 0.0 if mass is None else float(mass.attrib["value"])


def _joint(joint: ET.Element) -> Joint:
    limit = joint.find("limit")
    if limit is None:
        raise KeyError(f"limit of {joint.attrib['name']}")
    endless = math.inf if joint.attrib["type"] == "continuous" else 0.0
    return Joint(
        float(limit.get("lower", -endless)),
        float(limit.get("upper", endless)),
        float(limit.attrib["velocity"]),
        float(limit.attrib["effort"]),
    )
