"""Tells a camera that shows the same because nothing changes from one that is frozen, as far as pictures can."""

from __future__ import annotations

from services.task.faults import TaskFault
from services.task.geometry import Pose

NUDGE = 0.01
"""How far [rad] a head turns to and fro before a camera without noise, so that each picture differs from the last one:
by five pixels, more than any compression hides."""
_MOVED = 0.002  # [rad, m] by which a camera has to move for its picture to change


class Liveness:
    """Compares each picture with the last one, to the last byte.

    Attributes:
        nudge: how far [rad] the head has to be turned aside now: zero for a camera with noise, else to and fro.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget every picture."""
        self._data = b""
        self._camera: Pose | None = None
        self.nudge = 0.0

    def look(self, data: bytes, camera: Pose) -> TaskFault | None:
        """Why a picture is no news, taken by a camera at this pose in base; None if it is."""
        self.nudge = -self.nudge
        if self._camera is None or data != self._data:
            self._data, self._camera = data, camera
            return None
        self.nudge = self.nudge or NUDGE
        if camera.near(self._camera, _MOVED, _MOVED):
            return TaskFault("camera_repeats")
        return TaskFault("camera_frozen", f"although the camera has turned by {camera.angle(self._camera):.2f} rad")
