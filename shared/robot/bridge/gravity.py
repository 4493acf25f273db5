"""Whether the wrist's sensor measures in the axes that it is said to: gravity tells, while the arm is at rest.

What hangs on the sensor weighs m g, so a reading is f = m g Q d + b, with d the direction of gravity in sensor axes,
b the sensor's bias and Q = 1 if its axes and signs are right. Between postures b falls out. Before there are two that
differ enough, the weight that the description has beyond the sensor is looked for in the one, where a large bias is
taken for a wrong axis: so that is said, too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from shared.spatial import GRAVITY, Array, rotation_from_vector

AVERAGED = 0.5
"""[s] at rest over which a reading is averaged."""
_APART = math.cos(math.radians(20.0))  # postures whose gravity differs by less tell nothing
_LIGHTEST = 0.15  # [kg] below which a weight is lost in bias and noise
_WRONG = 0.5  # share [1] of the readings' differences that right axes leave unexplained at most
_RIGHT = 0.3  # share that an explanation leaves at most
_OFF = math.radians(35.0)  # between a single weight and gravity, above which a bias does not explain it
_MOST = 8  # postures that are kept


@dataclass
class _Pose:
    force: Array
    down: Array


class GravityWatch:
    """Compares readings at rest with gravity.

    Attributes:
        line: what is wrong with the sensor's axes; empty if nothing is known to be.

    Args:
        topic: of the sensor, for the line.
        mass: beyond the sensor [kg], by the description.
    """

    def __init__(self, topic: str, mass: float) -> None:
        self.line = ""
        self._topic = topic
        self._mass = mass
        self._poses: list[_Pose] = []
        self._sum: Array = np.zeros(3)
        self._count = 0
        self._since: float | None = None

    def hear(self, force: Array, down: Array, at_rest: bool, now: float) -> None:
        """Take one reading.

        Args:
            force: (3,) [N], sensor axes as the profile has them.
            down: direction of gravity (3,) in sensor axes, by the description.
            at_rest: whether arm and base stand still.
            now: time [s].
        """
        if not at_rest:
            self._since, self._count = None, 0
            return
        if self._since is None:
            self._since, self._sum, self._count = now, np.zeros(3), 0
        self._sum = self._sum + force
        self._count += 1
        if now - self._since >= AVERAGED:
            self._keep(_Pose(self._sum / self._count, down))
            self._since = None
            wrong = self._judged()
            self.line = f"{self._topic}: {wrong}" if wrong else ""

    def forget(self) -> None:
        """Begin anew: what hangs on the sensor may be another thing from now on. What was found stands."""
        self._poses = []
        self._since = None

    def _keep(self, pose: _Pose) -> None:
        """A new posture takes the place of those that differ little from it."""
        others = [old for old in self._poses if float(old.down @ pose.down) < _APART]
        self._poses = [*others[-_MOST + 1 :], pose]

    def _judged(self) -> str:
        if len(self._poses) > 1:
            return self._by_several()
        return self._by_one(self._poses[0]) if self._mass > 2.0 * _LIGHTEST else ""

    def _by_several(self) -> str:
        down = np.array([pose.down for pose in self._poses])
        force = np.array([pose.force for pose in self._poses])
        down, force = down - down.mean(axis=0), force - force.mean(axis=0)
        weight = float(np.linalg.norm(force) / np.linalg.norm(down))
        if weight < _LIGHTEST * GRAVITY or _left(force, down) < _WRONG:
            return ""
        cross = force.T @ down
        for words, axes in _explanations(math.atan2(cross[1, 0] - cross[0, 1], cross[0, 0] + cross[1, 1])):
            if _left(force, down @ axes.T) < _RIGHT:
                return f"as its weight changes from posture to posture, {words}"
        return (
            f"its readings change from posture to posture as no weight of {weight / GRAVITY:.1f} kg does in the frame "
            "that the profile names. Is [frames] sensor right, and [wrench] rotation? Does something touch the tool?"
        )

    def _by_one(self, pose: _Pose) -> str:
        weight = self._mass * GRAVITY
        size = float(np.linalg.norm(pose.force))
        if not 0.5 * weight < size < 2.0 * weight or _angle(pose.force, pose.down) < _OFF:
            return ""
        turn = math.atan2(pose.force[1], pose.force[0]) - math.atan2(pose.down[1], pose.down[0])
        for words, axes in _explanations(math.remainder(turn, math.tau)):
            if _angle(pose.force, axes @ pose.down) < 0.5 * _OFF:
                return f"by the tool's weight, {words} Or is its bias over {0.5 * weight:.0f} N?"
        return ""


def _explanations(turn: float) -> list[tuple[str, Array]]:
    about_z = rotation_from_vector((0.0, 0.0, turn))
    degrees = math.degrees(turn)
    return [
        ("it has the opposite sign: wanted is what is exerted on the robot, see [wrench] sign.", -np.eye(3)),
        (
            f"its axes are turned by {degrees:.0f} degrees about z of the sensor frame: see [wrench] rotation, or how "
            "the sensor is mounted.",
            about_z,
        ),
    ]


def _left(force: Array, down: Array) -> float:
    """Share [1] of forces (k, 3) that the best weight along directions (k, 3) leaves."""
    weight = max(0.0, float((force * down).sum() / (down * down).sum()))
    return float(np.linalg.norm(force - weight * down) / np.linalg.norm(force))


def _angle(a: Array, b: Array) -> float:
    return math.acos(min(1.0, max(-1.0, float(a @ b / (np.linalg.norm(a) * np.linalg.norm(b))))))
