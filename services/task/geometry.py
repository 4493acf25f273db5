"""Poses, and where the tool has to be relative to the marker."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shared.spatial import (
    Array,
    quaternion,
    quaternion_from_rpy,
    rotation_from_vector,
    rotation_matrix,
    rotation_vector,
    rpy_from_rotation,
)

QUARTER = math.pi / 2
STEEPEST = math.radians(30.0)  # [rad] of pitch up to which the tool's roll says how far a panel in it is turned


@dataclass(frozen=True, eq=False)
class Pose:
    """A frame in another one: origin (3,) [m] and rotation matrix (3, 3); if nothing else is said, the tool in base."""

    position: Array
    rotation: Array

    @classmethod
    def of(cls, position: Sequence[float] | Array, quaternion_xyzw: Sequence[float] | Array) -> Pose:
        """A pose from position (3,) [m] and quaternion (4,)."""
        return cls(np.array(position, dtype=float), rotation_matrix(quaternion_xyzw))

    @classmethod
    def from_rpy(cls, position: Sequence[float], rpy: Sequence[float]) -> Pose:
        """A pose from position (3,) [m] and roll, pitch, yaw (3,) [rad]."""
        return cls.of(position, quaternion_from_rpy(*rpy))

    @classmethod
    def from_row(cls, row: Array) -> Pose:
        """A pose from position and quaternion in a row (7,)."""
        return cls.of(row[:3], row[3:])

    @property
    def row(self) -> Array:
        """Position and unit quaternion (7,)."""
        return np.concatenate((self.position, self.orientation))

    @property
    def orientation(self) -> Array:
        """Unit quaternion (4,)."""
        return quaternion(self.rotation)

    @property
    def rpy(self) -> Array:
        """Roll, pitch, yaw (3,) [rad]; positive pitch points the x axis down."""
        return rpy_from_rotation(self.rotation)

    def __matmul__(self, inner: Pose) -> Pose:
        """``a_in_base @ b_in_a`` is ``b_in_base``."""
        return Pose(self.position + self.rotation @ inner.position, self.rotation @ inner.rotation)

    @property
    def inverse(self) -> Pose:
        """The outer frame in this one."""
        return Pose(-self.rotation.T @ self.position, self.rotation.T)

    def shifted(self, along_x: float) -> Pose:
        """The pose moved along its own x axis [m]."""
        return Pose(self.position + along_x * self.rotation[:, 0], self.rotation)

    def rolled_as(self, other: Pose) -> Pose:
        """The pose with the roll of another: roll refers to gravity, and means the same wherever the robot stands."""
        _, pitch, yaw = self.rpy.tolist()
        return Pose.from_rpy(self.position.tolist(), (float(other.rpy[0]), pitch, yaw))

    def distance(self, other: Pose) -> float:
        """Distance [m] of the origins."""
        return float(np.linalg.norm(self.position - other.position))

    def angle(self, other: Pose) -> float:
        """Angle [rad] of the rotation between the two."""
        return float(np.linalg.norm(rotation_vector(self.rotation @ other.rotation.T)))

    def near(self, other: Pose, distance: float, angle: float) -> bool:
        """Whether another pose is within a distance [m] and an angle [rad]."""
        return self.distance(other) <= distance and self.angle(other) <= angle

    def blended(self, other: Pose, share: float) -> Pose:
        """The pose ``share`` [1] of the way to another."""
        turn = share * rotation_vector(other.rotation @ self.rotation.T)
        position = self.position + share * (other.position - self.position)
        return Pose(position, rotation_from_vector(turn) @ self.rotation)


def wrapped(angle: float) -> float:
    """The same angle [rad] in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2 * math.pi)


def roll_since(home: Pose, pose: Pose) -> float:
    """How far the tool has turned about its own x axis [rad] since it was at ``home``.

    With R = Rz(yaw) Ry(pitch) Rx(roll), turning about the tool's x axis changes the roll alone.
    """
    return wrapped(float(pose.rpy[0] - home.rpy[0]))


def outside(position: Array, low: Sequence[float], high: Sequence[float]) -> str:
    """Which coordinate [m] leaves the box, and its range; empty if none does."""
    for name, value, least, most in zip("xyz", position.tolist(), low, high, strict=True):
        if not least <= value <= most:
            return f"{name} is {value:.2f} m, within reach is {least:g} to {most:g} m"
    return ""


def steep(tool: Pose) -> str:
    """By how much the tool points too far up or down for a panel to be carried, and the limit; empty if it does not."""
    pitch = float(tool.rpy[1])
    if abs(pitch) <= STEEPEST:
        return ""
    where = "down" if pitch > 0.0 else "up"
    return f"the tool points {where} by {_deg(abs(pitch))} degrees, allowed are {_deg(STEEPEST)}"


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.0f}"
