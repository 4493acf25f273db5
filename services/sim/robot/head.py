"""The robot's head: it pans and tilts, and carries the camera."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from services.sim.robot.kinematics import full_model, locked_except
from shared.robot.tiago import CAMERA_FRAME, HEAD, JOINTS, TORSO
from shared.spatial import Array


class Head:
    """Two joints that go where they are told at their speed, and the pose of the camera on top.

    Attributes:
        position: pan and tilt [rad].

    Args:
        start: positions [rad] at the start, by joint names.
    """

    def __init__(self, start: Mapping[str, float]) -> None:
        self._model = locked_except(full_model(), (TORSO, *HEAD))
        self._data = self._model.createData()
        self._frame = self._model.getFrameId(CAMERA_FRAME)
        self._speed = np.array([JOINTS[name].velocity for name in HEAD])
        self._start = np.array([start[name] for name in HEAD])
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
