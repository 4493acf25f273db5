"""The robot's head: it pans and tilts, and carries the camera."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from services.sim.robot.kinematics import full_model, locked_except
from shared.spatial import Array

JOINTS = ("head_1_joint", "head_2_joint")
"""Pan and tilt."""
OPTICAL_FRAME = "xtion_rgb_optical_frame"
TORSO = "torso_lift_joint"


class Head:
    """Two joints that go where they are told at their speed, and the pose of the camera on top.

    Attributes:
        position: pan and tilt [rad].
        ranges: what can be asked for [rad].

    Args:
        start: positions [rad] at the start, by joint names.
    """

    def __init__(self, start: Mapping[str, float]) -> None:
        self._model = locked_except(full_model(), (TORSO, *JOINTS))
        self._data = self._model.createData()
        self._frame = self._model.getFrameId(OPTICAL_FRAME)
        # Of the reduced model's joints the torso comes first.
        lower, upper = (
            self._model.lowerPositionLimit[1:].tolist(),
            self._model.upperPositionLimit[1:].tolist(),
        )
        self.ranges = dict(zip(("pan", "tilt"), zip(lower, upper, strict=True), strict=True))
        self._speed: Array = self._model.velocityLimit[1:].copy()
        self._start = np.array([start[name] for name in JOINTS])
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        self.position: Array = self._start.copy()
        self._target: Array = self._start.copy()
        self._moving = False

    def command(self, pan: float, tilt: float) -> None:
        """Take over wanted positions [rad]."""
        self._target = np.array((pan, tilt))
        self._moving = True

    def stay(self) -> None:
        """Go no further."""
        self._moving = False

    def advance(self, dt: float) -> None:
        """Move for ``dt`` [s]."""
        if self._moving:
            way = self._target - self.position
            self.position = self.position + np.clip(way, -self._speed * dt, self._speed * dt)
            self._moving = bool(way.any())

    def camera(self, torso: float) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of the optical frame in base, with the torso at ``torso`` [m]."""
        q = np.concatenate(((torso,), self.position))
        pin.framesForwardKinematics(self._model, self._data, q)
        pose = self._data.oMf[self._frame]
        return pose.translation.copy(), pose.rotation.copy()
