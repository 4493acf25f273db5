"""Markers in an image: exact corners, and both poses that they allow. The only module with OpenCV."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from services.task.geometry import Pose
from services.task.vision.marker_tracker import Candidate, Solution
from services.task.vision.subpixel_edges import MODULES, refined
from shared.messages import CameraImage
from shared.spatial import Array, rotation_from_vector, rotation_vector

Grey = NDArray[np.uint8]

DICTIONARY = cv2.aruco.DICT_4X4_50
_CORNER_WINDOW = 5  # [px] half the side of the window in which a corner is refined at first
_WINDOW_SHARE = 0.3  # [1] of a marker's module that half a window is at most
_MODULE_SAMPLES = np.linspace(0.3, 0.7, 5)  # [1] of a module at which its brightness is read
_RGB_CHANNELS = 3
MOST_PIXELS = 4_000_000  # more would keep the task from its other work for longer than a tenth of a second
LONGEST_SIDE = 8_000  # [px], OpenCV's sampling ends at 32767
_JPEG_START, _JPEG_FILL, _JPEG_SCAN = b"\xff\xd8", 0xFF, 0xDA
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # have the size; the three others define tables
_JPEG_WITHOUT_LENGTH = frozenset((0x01, *range(0xD0, 0xD9)))


class BadImage(ValueError):
    """An image that cannot be decoded; the text says why."""


class Detector:
    """Finds the markers of one dictionary.

    Args:
        size: side [m] of the printed black square.
    """

    def __init__(self, size: float) -> None:
        # The robot's computer has other work to do; one image takes milliseconds either way.
        cv2.setNumThreads(1)
        half = size / 2
        # Corners in the order in which the detector gives them, as IPPE's square form wants them.
        corners = ((-half, half, 0.0), (half, half, 0.0), (half, -half, 0.0), (-half, -half, 0.0))
        self._corners = np.array(corners)
        settings = cv2.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        settings.cornerRefinementWinSize = _CORNER_WINDOW
        settings.relativeCornerRefinmentWinSize = _WINDOW_SHARE
        settings.cornerRefinementMaxIterations = 50
        settings.cornerRefinementMinAccuracy = 0.005
        # A damaged code is a doubtful one: no bit is corrected.
        settings.errorCorrectionRate = 0.0
        self._dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARY)
        self._detector = cv2.aruco.ArucoDetector(self._dictionary, settings)

    def find(self, image: CameraImage, known: tuple[int, Pose] | None = None) -> list[Candidate]:
        """All markers in an image, with poses in its optical frame.

        Args:
            image: to look at.
            known: number of a marker that was tracked up to now, and where it has to be in the optical frame.

        Raises:
            BadImage: if the data is no image of the size that it claims, or none that OpenCV can work on.
        """
        try:
            return self._find(image, known)
        except cv2.error as problem:
            raise BadImage(f"OpenCV cannot work on it ({problem.err})") from None

    def _find(self, image: CameraImage, known: tuple[int, Pose] | None) -> list[Candidate]:
        grey = decoded(image)
        fx, fy, cx, cy = image.intrinsics.tolist()
        if fx <= 0.0 or fy <= 0.0:
            raise BadImage(f"intrinsics are {image.intrinsics.tolist()}, wanted fx and fy above 0")
        camera = np.array(((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)))
        corners, numbers, _ = self._detector.detectMarkers(grey)
        candidates = []
        for number, found in zip(() if numbers is None else numbers.ravel(), corners, strict=True):
            exact = _exact(grey, found)
            solutions = () if exact is None else self._solutions(exact, camera, image.distortion)
            candidates.append(Candidate(int(number), solutions))
        if known is not None and known[0] not in [candidate.number for candidate in candidates]:
            candidates += self._followed(grey, *known, camera, image.distortion)
        return candidates

    def _followed(self, grey: Grey, number: int, pose: Pose, camera: Array, distortion: Array) -> list[Candidate]:
        """The marker at the place where it has to be, if its edges are there and the whole of its code can be read.

        The search wants white all around the square, some of which the robot's own finger hides just before the grasp.
        """
        turn = rotation_vector(pose.rotation)
        seen, _ = cv2.projectPoints(self._corners, turn, pose.position, camera, distortion)
        exact = _exact(grey, seen)
        if exact is None or self._read(grey, exact) != number:
            return []
        return [Candidate(number, self._solutions(exact, camera, distortion))]

    def _read(self, grey: Grey, corners: Array) -> int | None:
        """The number that stands upright in a square of which half of the white along each edge is seen; else None."""
        places = (np.arange(-1, MODULES + 1)[:, None] + _MODULE_SAMPLES).ravel()
        grid = np.stack(np.meshgrid(places, places), axis=-1).reshape(-1, 1, 2)
        square = MODULES * np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
        onto = cv2.getPerspectiveTransform(square.astype(np.float32), corners.astype(np.float32))
        modules, samples = MODULES + 2, len(_MODULE_SAMPLES)
        points = cv2.perspectiveTransform(grid, onto).reshape(-1, 2).astype(float)
        bright = _brightness(grey, points).reshape(modules, samples, modules, samples)
        white = (bright > (bright.min() + bright.max()) / 2).mean(axis=(1, 3)) > 0.5
        along = slice(1, -1)
        margin = np.stack((white[0, along], white[-1, along], white[along, 0], white[along, -1]))
        border = np.stack((white[1, along], white[-2, along], white[along, 1], white[along, -2]))
        if border.any() or margin.mean(axis=1).min() < 0.5:
            return None
        code = white[2:-2, 2:-2].astype(np.uint8)
        known, number, quarters = self._dictionary.identify(code, 0.0)
        return int(number) if known and quarters == 0 else None

    def _solutions(self, corners: Array, camera: Array, distortion: Array) -> tuple[Solution, ...]:
        """The poses at both minima of the reprojection error, each refined until it is one, the better first."""
        count, turns, shifts, _ = cv2.solvePnPGeneric(
            self._corners, corners, camera, distortion, flags=cv2.SOLVEPNP_IPPE_SQUARE
        )
        solutions = []
        for turn, shift in zip(turns[:count], shifts[:count], strict=True):
            minimum = cv2.solvePnPRefineLM(self._corners, corners, camera, distortion, turn.copy(), shift.copy())
            seen, _ = cv2.projectPoints(self._corners, *minimum, camera, distortion)
            error = float(np.sqrt(np.mean(np.sum((seen.reshape(4, 2) - corners) ** 2, axis=1))))
            turn, shift = (np.array(part, dtype=np.float64).reshape(3) for part in minimum)
            if np.isfinite(turn).all() and np.isfinite(shift).all() and shift[2] > 0.0:
                solutions.append(Solution(shift, rotation_from_vector(turn), error))
        return tuple(sorted(solutions, key=lambda solution: solution.error))


def _exact(grey: Grey, corners: NDArray[Any]) -> Array | None:
    """Corners (4, 2) [px] of a square that are known roughly; None where no edge is to be seen."""
    return refined(corners.reshape(4, 2).astype(float), lambda points: _brightness(grey, points))


def _brightness(grey: Grey, points: Array) -> Array:
    """Interpolated brightness (n,) at points (n, 2) [px]; the rim goes on beyond the image."""
    x, y = (np.ascontiguousarray(part, dtype=np.float32)[None, :] for part in points.T)
    sampled = cv2.remap(grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return sampled.ravel().astype(float)


def decoded(image: CameraImage) -> Grey:
    """The image in grey (height, width), 8 bits.

    Raises:
        BadImage: if the data is no image of the size that it claims.
    """
    width, height = image.width, image.height
    if width * height > MOST_PIXELS or max(width, height) > LONGEST_SIDE:
        allowed = f"{MOST_PIXELS} pixels, {LONGEST_SIDE} on a side"
        raise BadImage(f"it is {width} x {height}, allowed are {allowed}")
    data = np.frombuffer(image.data, dtype=np.uint8)
    if image.encoding == "jpeg":
        size = jpeg_size(image.data)
        if size is None:
            raise BadImage(f"{data.size} bytes of data are no jpeg image")
        if size != (width, height):
            raise BadImage(f"jpeg is {size[0]} x {size[1]}, declared are {width} x {height}")
        try:
            grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        except cv2.error as problem:
            raise BadImage(f"jpeg data cannot be decoded: {problem.err}") from None
        if grey is None:
            raise BadImage(f"{data.size} bytes of jpeg data cannot be decoded")
        return grey.astype(np.uint8, copy=False)
    if data.size != width * height * _RGB_CHANNELS:
        raise BadImage(f"{data.size} bytes of rgb8 data, wanted {width} x {height} x {_RGB_CHANNELS}")
    grey = cv2.cvtColor(data.reshape(height, width, _RGB_CHANNELS), cv2.COLOR_RGB2GRAY)
    return grey.astype(np.uint8, copy=False)


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Width and height [px] in a JPEG image's header, None if this is none; nothing is decoded to find that out."""
    if not data.startswith(_JPEG_START):
        return None
    at = len(_JPEG_START)
    while at + 9 <= len(data) and data[at] == _JPEG_FILL:
        marker = data[at + 1]
        if marker in _JPEG_FRAMES:
            return int.from_bytes(data[at + 7 : at + 9], "big"), int.from_bytes(data[at + 5 : at + 7], "big")
        if marker == _JPEG_SCAN:
            return None
        if marker == _JPEG_FILL:
            at += 1
        elif marker in _JPEG_WITHOUT_LENGTH:
            at += 2
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None
