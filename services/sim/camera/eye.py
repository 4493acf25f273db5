"""The head camera in the loop: when it takes a picture, and what its connection makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from services.sim.camera.head_camera import Camera
from services.sim.camera.sights import Sights
from services.sim.robot.sensor_line import SensorLine
from shared.messages import CameraImage
from shared.service import Output
from shared.topics import SENSOR_CAMERA


class Eye:
    """Camera, what it sees, and the line that its messages take.

    Attributes:
        sights: what there is to see.
    """

    def __init__(self, sights: Sights, camera: Camera, line: SensorLine) -> None:
        self.sights = sights
        self._camera = camera
        self._line = line

    @property
    def complaint(self) -> str:
        """Why there are no pictures any more, or ""."""
        return self._camera.complaint

    def shots(self, exposed: bool, time: float, tick: float, stretch: float) -> list[Output]:
        """The messages of a tick.

        Args:
            exposed: whether a picture is to be taken now.
            time: simulated [s].
            tick: simulated time [s] since the last call.
            stretch: real time per simulated time.
        """
        if exposed:
            look = replace(self.sights.look(), brighter=float(self._line.shift(np.zeros(1))[0]))
            self._camera.expose(look, time)
        shot = self._camera.shot(time)
        if shot is None:
            return self._line.send([], tick)
        image: CameraImage = self._line.stick(lambda: shot.image)
        return self._line.send([Output(SENSOR_CAMERA, image, late=shot.age * stretch)], tick)
