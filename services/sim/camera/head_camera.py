"""The head camera: takes pictures at its rate while somebody wants them."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from PIL import Image

from services.sim.camera.renderer import Renderer
from services.sim.camera.sight import HEIGHT, INTRINSICS, WIDTH, Look, Sight
from shared.messages import CameraImage
from shared.spatial import quaternion

QUALITY = 90
"""Of the JPEG images."""


class Darkroom(Protocol):
    """Develops one picture at a time.

    Attributes:
        complaint: why it does not any more, or "".
    """

    complaint: str

    def expose(self, look: Look) -> None:
        """Begin with a picture."""
        ...

    def picture(self) -> bytes | None:
        """The picture begun as a JPEG image, once, when it is ready."""
        ...


class OwnDarkroom:
    """Develops within the call: for simulated time, in which nothing takes any."""

    complaint = ""

    def __init__(self, sight: Sight) -> None:
        self._sight = sight
        self._look: Look | None = None

    @cached_property
    def _renderer(self) -> Renderer:
        return Renderer(self._sight)

    def expose(self, look: Look) -> None:
        self._look = look

    def picture(self) -> bytes | None:
        look, self._look = self._look, None
        return None if look is None else developed(self._renderer, look)


def developed(renderer: Renderer, look: Look) -> bytes:
    """One picture as a JPEG image."""
    file = io.BytesIO()
    Image.fromarray(renderer.picture(look)).save(file, "JPEG", quality=QUALITY)
    return file.getvalue()


@dataclass(frozen=True)
class Shot:
    """An image, and how old [s] what it shows is."""

    image: CameraImage
    age: float


class Camera:
    """Turns looks into messages.

    Args:
        darkroom: where pictures are rendered.
    """

    def __init__(self, darkroom: Darkroom) -> None:
        self._darkroom = darkroom
        self._exposed: tuple[Look, float] | None = None

    @property
    def complaint(self) -> str:
        """Why there are no pictures any more, or ""."""
        return self._darkroom.complaint

    def expose(self, look: Look, time: float) -> None:
        """Take a picture at a time [s], unless one is in the making."""
        if self._exposed is None:
            self._exposed = look, time
            self._darkroom.expose(look)

    def shot(self, time: float) -> Shot | None:
        """The picture taken last, if it has become ready by a time [s]."""
        if self._exposed is None or (data := self._darkroom.picture()) is None:
            return None
        (look, taken), self._exposed = self._exposed, None
        image = CameraImage(
            WIDTH,
            HEIGHT,
            "jpeg",
            data,
            np.array(INTRINSICS),
            np.zeros(5),
            look.position,
            quaternion(look.rotation),
        )
        return Shot(image, time - taken)
