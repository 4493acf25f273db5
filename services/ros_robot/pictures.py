"""The camera's pictures as ROS has them: pixels without compression, and a calibration beside them."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from shared.messages import CameraImage
from shared.robot.far_side import Calibration, Picture

_RATIONAL = np.array((0.1, -0.2, 0.001, 0.001, 0.05, 0.1, -0.15, 0.04))
"""Eight coefficients of a lens that distorts: k1 k2 p1 p2 k3 k4 k5 k6."""


def decoded(image: CameraImage, encoding: str) -> Picture:
    """A JPEG image as pixels in an encoding: rgb8, bgr8 or mono8; without any, a picture that cannot be read."""
    try:
        picture = Image.open(io.BytesIO(image.data)).convert("L" if encoding == "mono8" else "RGB")
    except OSError:
        return Picture(image.width, image.height, encoding, b"")
    pixels = np.asarray(picture)
    if encoding == "bgr8":
        pixels = pixels[:, :, ::-1]
    return Picture(image.width, image.height, encoding, pixels.tobytes())


def calibration(image: CameraImage, rational: bool = False) -> Calibration:
    """What belongs to the image: no distortion, five zeros, or the eight coefficients of a rational model."""
    distortion, model = (_RATIONAL, "rational_polynomial") if rational else (np.zeros(5), "plumb_bob")
    return Calibration(image.width, image.height, image.intrinsics, distortion, model)
