"""Proves what is told about the camera: the head shows it the marker in different places of the picture.

The panel rests meanwhile. At the end the head looks as at first: what moved shows there.
"""

from __future__ import annotations

import math

import numpy as np

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.vision.consistency import AGREE, AGREE_ANGLE, Verdict, View, differences, judged
from services.task.vision.marker_tracker import Candidate
from services.task.vision.projection import Calibration
from shared.messages import CameraImage
from shared.spatial import Array

_PLACES = ((1, 1), (1, -1), (-1, -1), (-1, 1))
"""Where the marker is shown: right (1) or left, and below (1) or above. For 1 and 1 the head pans left and tilts up."""
VIEWS = len(_PLACES) + 2  # with the first, and the same once more
_ROOM = 0.8  # [1] of the way to the picture's edge: a head that pans moves what is below it along a curve
_BORDER = 0.35  # [1] of its width that is left around the marker: its white, and how it grows towards the edge
_STILL = 0.002  # [rad, m] by which a camera at rest may move
_LONGEST = 2.0  # [s] until a view is there; then the head turns half as far
_TRIES = 3
_SPREAD = 0.2  # [1] of the picture's width and height by which the places have to differ at least


class Proof:
    """One sequence of views, and the verdict on them.

    Attributes:
        turn: how far the head has to pan and tilt [rad] from where it looked at first; None while there is no marker.
        verdict: None until all views are there.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self._settings = parameters
        self.reset()

    def reset(self, doubt: TaskFault | None = None) -> None:
        """Begin anew at the next image; ``doubt`` says why."""
        self.turn: tuple[float, float] | None = None
        self.verdict: Verdict | None = None
        self._failure = doubt
        self._told: Calibration | None = None
        self._source = 0
        self._views: list[View] = []
        self._turns: list[tuple[float, float]] = []
        self._still: list[View] = []
        self._seen: Pose | None = None
        self._from = (0.0, 0.0)
        self._waited, self._tries = 0.0, 0

    @property
    def proven(self) -> bool:
        """Whether the marker's pose is to be gone by."""
        return self.verdict is not None and self.verdict.consistent

    @property
    def doubt(self) -> TaskFault | None:
        """Why nobody may go by the marker's pose; None if one may."""
        if self.verdict is None:
            return self._failure or TaskFault("marker_unproven", f"{len(self._views)} of {VIEWS} views")
        return None if self.proven else TaskFault("camera_wrong", _described(self.verdict))

    def advance(self, dt: float) -> None:
        """Let time [s] pass."""
        if self.turn is None or self.verdict is not None:
            return
        self._waited += dt
        if self._waited < _LONGEST:
            return
        self._waited, self._still = 0.0, []
        if not self._views:
            return self.reset(self._failure)
        if self._seen is not None and self._moved(self._seen) < self._asked / 4.0:
            return self.reset(TaskFault("camera_still", f"in {_LONGEST:g} s"))
        self._tries += 1
        if not self._turns or self._tries >= _TRIES:
            return self._next()
        self.turn = (self.turn[0] / 2.0, self.turn[1] / 2.0)

    def look(
        self, image: CameraImage, session: int, camera: Pose, found: Candidate | None, trusted: Pose | None
    ) -> None:
        """Take in an image.

        Args:
            image: with its calibration.
            session: of who sends it.
            camera: the optical frame in base when it was taken.
            found: the marker in it, if it is to be believed.
            trusted: the marker in base, if one is tracked.
        """
        told = Calibration(image.intrinsics, image.distortion, self._settings.marker_size)
        if self._told is not None and (session != self._source or not told.same(self._told)):
            self.reset()
        if self.verdict is not None:
            settings = self._settings
            # By a camera that is wrong a panel at rest is elsewhere in each view.
            if (
                self.proven
                and trusted
                and not trusted.near(self.verdict.marker, settings.marker_jump, settings.marker_jump_angle)
            ):
                self.reset(TaskFault("marker_moved", "since the camera was proven"))
            return
        self._seen = camera
        if found is None:
            return
        self._told, self._source = told, session
        self.turn = self.turn or (0.0, 0.0)
        if self._still and not camera.near(self._still[0].camera, _STILL, _STILL):
            self._still = []
        self._still.append(View(found.corners, camera))
        if len(self._still) < self._settings.marker_confirm or self._moved(camera) < self._asked / 2.0:
            return
        corners = np.mean([view.corners for view in self._still], axis=0)
        self._take(View(corners, camera), image, camera @ found.solutions[0].pose)

    def _take(self, view: View, image: CameraImage, marker: Pose) -> None:
        """Keep a view, and go on to the next or to the verdict."""
        focal = float(image.intrinsics[:2].min())
        if self._views:
            away = float(np.abs(view.corners - self._views[-1].corners).max())
            if away < self._moved(view.camera) * focal / 10.0:
                turned = f"although the camera has turned by {self._moved(view.camera):.2f} rad"
                return self.reset(TaskFault("camera_frozen", turned))
        else:
            self._turns = [*_turns(view.corners, image), (0.0, 0.0)]
        self._views.append(view)
        self._from = self.turn or (0.0, 0.0)
        if self._turns:
            return self._next()
        self._judge(image, marker)

    def _judge(self, image: CameraImage, marker: Pose) -> None:
        assert self._told is not None
        settings = self._settings
        told, views = self._told, self._views
        # Each view's corners are means over images.
        accuracy = settings.marker_accuracy / math.sqrt(settings.marker_confirm)
        spread = np.ptp([view.corners.mean(axis=0) for view in views], axis=0) / (image.width, image.height)
        if spread.min() < _SPREAD:
            places = "places that are {:.0%} of its width and {:.0%} of its height apart".format(*spread)
            return self.reset(TaskFault("marker_unproven", f"{places}, wanted are {_SPREAD:.0%}"))
        apart, turned = differences((views[0], views[-1]), marker, told, accuracy)
        if apart > AGREE / 2.0 or turned > AGREE_ANGLE:
            return self.reset(TaskFault("marker_moved", f"by {apart * 1e3:.0f} mm while the head looked at it"))
        self.verdict = judged(views[:-1], marker, told, accuracy, settings.head_accuracy)
        self.turn, self._failure = (0.0, 0.0), None

    def _next(self) -> None:
        """Turn the head to the next place; after the last one, begin anew: its view is missing."""
        if not self._turns:
            return self.reset(self._failure)
        self.turn, self._waited, self._tries, self._still = self._turns.pop(0), 0.0, 0, []

    @property
    def _asked(self) -> float:
        """About how far [rad] the camera has to turn from the last view for the next one; 0 for the first."""
        if not self._views or self.turn is None:
            return 0.0
        return math.hypot(self.turn[0] - self._from[0], self.turn[1] - self._from[1])

    def _moved(self, camera: Pose) -> float:
        """How far [rad] a camera has turned since the last view; 0 before the first."""
        return camera.angle(self._views[-1].camera) if self._views else 0.0


def _turns(corners: Array, image: CameraImage) -> list[tuple[float, float]]:
    """Pan and tilt [rad], from the head's present pose, that bring a marker near each corner of the picture."""
    size, focal, centre = np.array((image.width, image.height)), image.intrinsics[:2], image.intrinsics[2:]
    low, high = corners.min(axis=0), corners.max(axis=0)
    border = _BORDER * (high - low)

    def angle(pixel: Array) -> Array:
        return np.arctan((pixel - centre) / focal)

    room = {
        1: _ROOM * np.maximum(0.0, angle(size - 1.0 - border) - angle(high)),
        -1: _ROOM * np.maximum(0.0, angle(low) - angle(border)),
    }
    return [(x * float(room[x][0]), y * float(room[y][1])) for x, y in _PLACES]


def _described(verdict: Verdict) -> str:
    differ = f"{verdict.apart * 1e3:.0f} mm and {math.degrees(verdict.turned):.1f} degrees"
    allowed = f"allowed are {AGREE * 1e3:.0f} mm and {math.degrees(AGREE_ANGLE):.0f} degrees"
    if not verdict.causes:
        return f"{differ}, {allowed}. No single cause explains it: look at the head's joints, and that the panel rests"
    aside = f"would have the marker {verdict.shift * 1e3:.0f} mm aside"
    return f"{differ}, {allowed}. This explains it, and {aside}: {'; or '.join(verdict.causes)}"
