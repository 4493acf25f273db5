"""The head camera: its picture, its pose and calibration as a frustum, and the marker as the task has found it."""

from __future__ import annotations

import numpy as np
import rerun as rr

from services.viewer.draw.colours import GREEN, GREY
from services.viewer.draw.robot import BASE, at, axes
from services.viewer.sample import Newest, Sample
from shared.messages import CameraImage, TaskStatus

CAMERA, MARKER = f"{BASE}/camera", f"{BASE}/marker"
PICTURE = f"{CAMERA}/picture"
FRESH, GONE = 0.5, 3.0
"""Ages [s] up to which a marker is drawn as seen now, and drawn at all: what moves is not where it was."""
_MODES = {"rgb8": (rr.ColorModel.RGB, 3), "bgr8": (rr.ColorModel.BGR, 3), "mono8": (rr.ColorModel.L, 1)}
_ARM = 0.1  # [m] from the marker's middle to the end of each of its axes


def style(rec: rr.RecordingStream) -> None:
    """What stays as it is."""
    rec.log(f"{MARKER}/name", rr.Points3D.from_fields(radii=[0.012]), static=True)


def picture(rec: rr.RecordingStream, sample: Sample[CameraImage], newest: Newest) -> None:
    """The picture and where it was taken from."""
    image = sample.message
    rec.log(CAMERA, at(image.position, image.orientation))
    fx, fy, cx, cy = image.intrinsics.tolist()
    if fx > 0.0 and fy > 0.0:
        matrix = np.array(((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)))
        size = (image.width, image.height)
        rec.log(PICTURE, rr.Pinhole(image_from_camera=matrix, resolution=size, image_plane_distance=0.15))
    if image.encoding in _MODES:
        mode, channels = _MODES[image.encoding]
        shape = (image.height, image.width, channels)
        if len(image.data) == np.prod(shape):
            rec.log(PICTURE, rr.Image(np.frombuffer(image.data, np.uint8).reshape(shape), color_model=mode))
    else:
        rec.log(PICTURE, rr.EncodedImage(contents=image.data, media_type=f"image/{image.encoding}"))


def marker(rec: rr.RecordingStream, sample: Sample[TaskStatus], newest: Newest) -> None:
    """The marker's middle and axes where the task believes them, grey if that is not of now; its size is not told."""
    found = sample.message.marker
    if found is None or found.age > GONE:
        rec.log(MARKER, rr.Clear(recursive=True))
        return
    seen = found.age <= FRESH
    label = "marker" if seen else f"marker, as seen {found.age:.1f} s ago"
    rec.log(MARKER, at(found.position, found.orientation), axes(_ARM))
    name = rr.Points3D.from_fields(positions=[(0.0, 0.0, 0.0)], labels=[label], colors=[GREEN if seen else GREY])
    rec.log(f"{MARKER}/name", name)
