"""The robot from its description: shapes once, joints as they move, all of one instant in one call.

A joint's frame in its parent's is ``origin * motion(q)``: a turn about its axis, or a way along it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from services.viewer.draw.colours import AXES
from services.viewer.sample import Newest, Sample
from shared.messages import BaseState, JointState
from shared.robot.tiago import URDF
from shared.spatial import (
    Array,
    quaternion,
    quaternion_from_rpy,
    quaternion_from_vector,
    rotation_from_vector,
    rotation_matrix,
)

BASE = "world/base"
"""Entity whose axes are those of ``base``."""
_JOINTS = "tf/joints"
_UNSEEN = 1e-4
"""Motion of a joint [rad, m] that nobody sees."""
REPEAT = 5.0
"""Time [s] after which what has not changed is drawn again, for whoever comes later: the oldest is forgotten."""


def shapes(side: str = "") -> str:
    """Entity of a robot's shapes: rerun wants a single name, also in the part of a stream below a path."""
    return f"{side}-robot" if side else "robot"


class Robot:
    """One robot's description in a stream.

    Args:
        rec: gets the shapes, which hang on ``BASE``.
        side: path below which the stream draws; empty for all of it.
        urdf: the description.

    Raises:
        OSError, ValueError: it cannot be read.
    """

    def __init__(self, rec: rr.RecordingStream, side: str = "", urdf: Path = URDF) -> None:
        tree = rr.urdf.UrdfTree.from_file_path(
            urdf,
            entity_path_prefix=shapes(side),
            frame_prefix=side or None,
            static_transform_entity_path=f"{side}/tf/static",
        )
        tree.log_urdf_to_recording(rec)
        above = f"{side}/{BASE}".removeprefix("/")
        root = rr.Transform3D(parent_frame=f"tf#/{above}", child_frame=side + tree.root_link().name)
        rec.log("tf/root", root, static=True)
        self._joints = {joint.name: _Moving.of(joint, side) for joint in tree.joints() if joint.joint_type != "fixed"}
        self._shown: dict[str, float] = {}
        self._all_at = -math.inf

    def joints(self, rec: rr.RecordingStream, sample: Sample[JointState], newest: Newest) -> None:
        """Move the joints; those that the description does not know are left out."""
        message = sample.message
        if sample.time - self._all_at >= REPEAT:
            self._all_at = sample.time
            self._shown.clear()
        known = [
            (self._joints[name], position)
            for name, position in zip(message.name, message.position.tolist(), strict=True)
            if name in self._joints and abs(position - self._shown.get(name, math.inf)) > _UNSEEN
        ]
        self._shown |= {joint.name: position for joint, position in known}
        if not known:
            return
        rec.send_columns(
            _JOINTS,
            indexes=[rr.TimeColumn("time", duration=[sample.time] * len(known))],
            columns=rr.Transform3D.columns(
                translation=[joint.translation(position) for joint, position in known],
                quaternion=[joint.quaternion(position) for joint, position in known],
                parent_frame=[joint.parent for joint, _ in known],
                child_frame=[joint.child for joint, _ in known],
            ),
        )


class _Moving(NamedTuple):
    """A joint: its name and frames, origin and axis in its parent's frame, and whether it slides instead of turning."""

    name: str
    parent: str
    child: str
    origin: Array
    rotation: Array
    axis: Array
    slides: bool

    @classmethod
    def of(cls, joint: rr.urdf.UrdfJoint, side: str) -> _Moving:
        rotation = rotation_matrix(quaternion_from_rpy(*joint.origin_rpy))
        slides = joint.joint_type == "prismatic"
        origin, axis = np.array(joint.origin_xyz), np.array(joint.axis)
        frames = side + joint.parent_link, side + joint.child_link
        return cls(joint.name, *frames, origin, rotation, axis, slides)

    def translation(self, position: float) -> Array:
        return self.origin + self.rotation @ (position * self.axis) if self.slides else self.origin

    def quaternion(self, position: float) -> Array:
        turn = np.zeros(3) if self.slides else position * self.axis
        return quaternion(self.rotation @ rotation_from_vector(turn))


def at(position: ArrayLike, orientation: Array) -> rr.Transform3D:
    """A pose: position [m], orientation [x, y, z, w]."""
    return rr.Transform3D(translation=position, quaternion=rr.Quaternion(xyzw=orientation))


def axes(length: float) -> rr.Arrows3D:
    """Coordinate axes [m]; unlike rerun's own they are gone when they are taken away."""
    return rr.Arrows3D(vectors=length * np.eye(3), colors=AXES, radii=[0.003])


def base(rec: rr.RecordingStream, sample: Sample[BaseState], newest: Newest) -> None:
    """Move the robot by its odometry."""
    x, y = sample.message.position.tolist()
    turn = quaternion_from_vector((0.0, 0.0, sample.message.yaw))
    rec.log(BASE, at((x, y, 0.0), turn))
