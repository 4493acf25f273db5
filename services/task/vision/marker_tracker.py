"""Which marker to believe: what a detector found becomes one trusted pose in base, or the reason why not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from shared.spatial import Array

_SMOOTHING = 0.3  # [1] share of a new pose in the trusted one: a single image is off by up to twice as much
SAME_ANGLE = 0.05  # [rad] between two solutions up to which they are one
_ODDS = 2.0 * math.log(1000.0)
"""Difference of two solutions' squared errors, in variances of a coordinate, from which one is 1000 times likelier."""


@dataclass(frozen=True, eq=False)
class Solution:
    """One pose that the four corners allow.

    Attributes:
        position: marker (3,) [m] in the optical frame.
        rotation: marker (3, 3) in the optical frame; marker axes: x right, y up on the print, z out of it.
        error: root mean square reprojection error [px].
    """

    position: Array
    rotation: Array
    error: float

    @property
    def pose(self) -> Pose:
        """The marker in the optical frame."""
        return Pose(self.position, self.rotation)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A marker in an image.

    Attributes:
        number: of it.
        solutions: poses that it may have, clearly different ones, the best first; none if its edges are not to be seen.
        corners: (4, 2) [px].
    """

    number: int
    solutions: tuple[Solution, ...]
    corners: Array


class MarkerTracker:
    """Keeps the trusted pose of the marker in base.

    The first ``marker_confirm`` accepted images have to agree; then each has to agree with the one before. A pose older
    than ``marker_max_age`` is forgotten, so that a panel that was really moved is found again, by as many images.

    Attributes:
        seen: the marker in the last image, if its pose there is beyond doubt.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self._settings = parameters
        self.reset()

    def reset(self) -> None:
        """Forget every image."""
        self._pose: Pose | None = None
        self._age = 0.0
        self._confirmed = 0
        self._since_image = self._between = 0.0
        self._image_seen = False
        self._doubt: TaskFault | None = None
        self.seen: Candidate | None = None

    @property
    def pose(self) -> Pose | None:
        """The marker in base, if it is to be trusted now."""
        if self._pose is None or self._confirmed < self._settings.marker_confirm:
            return None
        return self._pose

    def known(self, camera: Pose) -> tuple[int, Pose] | None:
        """The marker's number and where it has to be in an optical frame whose pose in base is given."""
        pose = self.pose
        return None if pose is None else (self._settings.marker_id, camera.inverse @ pose)

    @property
    def age(self) -> float:
        """Time [s] since the image that the pose is from."""
        return self._age

    @property
    def doubt(self) -> TaskFault | None:
        """Why there is no pose to trust; None if there is one."""
        if self.pose is not None:
            return None
        limit = self._settings.marker_max_age
        if not self._image_seen:
            return TaskFault("camera_never")
        if self._between > limit and self._since_image <= 2.0 * self._between:
            return TaskFault("camera_slow", f"{self._between:.1f} s apart, allowed are {limit:g} s")
        if self._since_image > limit:
            return TaskFault("camera_silent", f"{self._since_image:.1f} s, allowed are {limit:g} s")
        if self._doubt is None:
            return TaskFault("marker_new", f"{self._confirmed} of {self._settings.marker_confirm} images")
        return self._doubt

    def advance(self, dt: float) -> None:
        """Let time [s] pass."""
        self._since_image += dt
        self._age += dt
        if self._age > self._settings.marker_max_age:
            self._pose, self._confirmed = None, 0

    def useless(self, fault: TaskFault) -> None:
        """Take note of an image that is of no use."""
        self._arrived()
        self._doubt, self.seen = fault, None

    def look(self, found: Sequence[Candidate], camera: Pose, age: float, hindrance: TaskFault | None = None) -> None:
        """Take in what an image shows.

        Args:
            found: all markers in it.
            camera: the optical frame in base when it was taken.
            age: time [s] since it was taken.
            hindrance: why it may show nothing.
        """
        self._arrived()
        self.seen = None
        self._doubt = self._accept(found, camera, age, hindrance)

    def _arrived(self) -> None:
        self._between = self._since_image if self._image_seen else 0.0
        self._image_seen, self._since_image = True, 0.0

    def _accept(
        self, found: Sequence[Candidate], camera: Pose, age: float, hindrance: TaskFault | None
    ) -> TaskFault | None:
        settings = self._settings
        if age > settings.marker_max_age:
            return TaskFault("marker_old", f"{age:.2f} s old, allowed are {settings.marker_max_age:g} s")
        ours = [candidate for candidate in found if candidate.number == settings.marker_id]
        if not ours and hindrance is not None:
            return hindrance
        if not ours:
            others = ", ".join(str(candidate.number) for candidate in found[:5])
            if others:
                return TaskFault("marker_other", f"seen {others}, wanted {settings.marker_id}")
            return TaskFault("marker_missing")
        if len(ours) > 1:
            return TaskFault("marker_twice", f"{len(ours)} with the number {settings.marker_id}")
        doubt = self._doubtful(ours[0].solutions)
        if doubt is not None:
            return doubt
        self.seen = ours[0]
        pose = camera @ ours[0].solutions[0].pose
        if self._pose is not None:
            away, turned = pose.distance(self._pose), pose.angle(self._pose)
            if away > settings.marker_jump or turned > settings.marker_jump_angle:
                allowed = f"allowed are {settings.marker_jump:g} m and {settings.marker_jump_angle:g} rad"
                return TaskFault("marker_jump", f"{away:.2f} m and {turned:.2f} rad, {allowed}")
            pose = self._pose.blended(pose, _SMOOTHING)
        self._pose, self._age = pose, age
        self._confirmed = min(self._confirmed + 1, settings.marker_confirm)
        return None

    def _doubtful(self, solutions: Sequence[Solution]) -> TaskFault | None:
        """Why the corners give no clear pose, if they do not."""
        settings = self._settings
        if not solutions:
            return TaskFault("marker_edges")
        best = solutions[0].error
        if best > settings.marker_error:
            return TaskFault("marker_error", f"{best:.2f} px off, allowed are {settings.marker_error:g} px")
        # Two of the eight coordinates are left over, so the best fit's error says what they were measured to here.
        variance = settings.marker_accuracy**2 + 4.0 * best**2 / 2.0
        if solutions[1:] and 4.0 * (solutions[1].error ** 2 - best**2) < _ODDS * variance:
            both = f"with {solutions[1].error:.2f} px as with {best:.2f} px"
            return TaskFault("marker_ambiguous", f"{both}, measured to {settings.marker_accuracy:g} px")
        return None
