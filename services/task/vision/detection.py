"""Markers in an image: exact corners, and both poses that they allow. The only module with OpenCV."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.vision.headers import jpeg_header, png_header
from services.task.vision.marker_tracker import SAME_ANGLE, Candidate, Solution
from services.task.vision.projection import SQUARE
from services.task.vision.subpixel_edges import MODULES, refined
from shared.messages import CameraImage
from shared.spatial import Array, rotation_from_vector, rotation_vector

Grey = NDArray[np.uint8]

DICTIONARY = cv2.aruco.DICT_4X4_50
_CORNER_WINDOW = 5  # [px] half the side of the window in which a corner is refined at first
_WINDOW_SHARE = 0.3  # [1] of a marker's module that half a window is at most
_MODULE_SAMPLES = np.linspace(0.3, 0.7, 5)  # [1] of a module at which its brightness is read
MOST_PIXELS = 4_000_000  # more would keep the task from its other work for longer than a tenth of a second
LONGEST_SIDE = 8_000  # [px], OpenCV's sampling ends at 32767
_RAW = {"rgb8": (3, cv2.COLOR_RGB2GRAY), "bgr8": (3, cv2.COLOR_BGR2GRAY), "mono8": (1, None)}
"""Channels of each uncompressed encoding, and how they become grey."""
_HEADERS = {"jpeg": jpeg_header, "png": png_header}
_LENSES = {"plumb_bob": (0, 4, 5), "rational_polynomial": (0, 8)}
"""Numbers of coefficients of each model, as ROS names them."""
_FISHEYES = ("equidistant", "fisheye", "kannala_brandt")
_COARSEST = 350.0  # [px] focal length: below it a marker of 0.15 m was found 11 mm off at 1 m
_RECTIFY = "rectify the picture, and send its own intrinsics and no distortion with it"
_ZOOM = 100.0  # [1] of a focal length to the picture's width at most, and the other way round
_BLANK = 3.0  # [of 255] of standard deviation below which a picture shows nothing


class BadImage(ValueError):
    """An image of no use.

    Attributes:
        fault: what is wrong with it.
    """

    def __init__(self, problem: str, row: str = "camera_broken") -> None:
        super().__init__(problem)
        self.fault = TaskFault(row, problem)


class Detector:
    """Finds the markers of one dictionary.

    Args:
        size: side [m] of the printed black square.
    """

    def __init__(self, size: float) -> None:
        # The robot's computer has other work to do; one image takes milliseconds either way.
        cv2.setNumThreads(1)
        # In the order in which the detector gives them, as IPPE's square form wants them.
        self._corners = size * SQUARE
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
        self._grey: Grey = np.zeros((1, 1), np.uint8)

    def find(self, image: CameraImage, known: tuple[int, Pose] | None = None) -> list[Candidate]:
        """All markers in an image, with poses in its optical frame.

        Args:
            image: to look at.
            known: number of a marker that was tracked up to now, and where it has to be in the optical frame.

        Raises:
            BadImage: if the data is no image of the size that it claims or none that OpenCV can work on, or for a
                calibration of no use.
        """
        try:
            return self._find(image, known)
        except cv2.error as problem:
            raise BadImage(f"OpenCV cannot work on it ({problem.err})") from None

    def _find(self, image: CameraImage, known: tuple[int, Pose] | None) -> list[Candidate]:
        grey = self._grey = decoded(image)
        fx, fy, cx, cy = image.intrinsics.tolist()
        if problem := _unknown_lens(image):
            raise BadImage(problem, "camera_model")
        camera = np.array(((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)))
        corners, numbers, _ = self._detector.detectMarkers(grey)
        candidates = []
        for number, found in zip(() if numbers is None else numbers.ravel(), corners, strict=True):
            exact = _exact(grey, found)
            solutions = () if exact is None else self._solutions(exact, camera, image.distortion)
            rough = found.reshape(4, 2).astype(float)
            candidates.append(Candidate(int(number), solutions, rough if exact is None else exact))
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
        return [Candidate(number, self._solutions(exact, camera, distortion), exact)]

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

    def hindrance(self, number: int) -> TaskFault | None:
        """Why the last picture may show no marker of a number; None if nothing is known."""
        if (contrast := float(self._grey.std())) < _BLANK:
            return TaskFault("camera_blank", f"brightness {self._grey.mean():.0f} of 255, differing by {contrast:.1f}")
        # A mirrored code is none of the dictionary, but for those numbers that `marker_id` must not be.
        numbers = self._detector.detectMarkers(np.ascontiguousarray(self._grey[:, ::-1]))[1]
        mirrored = numbers is not None and number in numbers
        return TaskFault("marker_mirrored", f"number {number}") if mirrored else None

    def _solutions(self, corners: Array, camera: Array, distortion: Array) -> tuple[Solution, ...]:
        """The poses at all minima of the reprojection error that are found, the best first.

        Looked for from IPPE's two poses, and from one that faces the camera: exactly head-on IPPE fails.
        """
        count, turns, shifts, _ = cv2.solvePnPGeneric(
            self._corners, corners, camera, distortion, flags=cv2.SOLVEPNP_IPPE_SQUARE
        )
        starts = [*zip(turns[:count], shifts[:count], strict=True), self._facing(corners, camera, distortion)]
        solutions: list[Solution] = []
        for turn, shift in starts:
            if not (np.isfinite(turn).all() and np.isfinite(shift).all()):
                continue
            minimum = cv2.solvePnPRefineLM(self._corners, corners, camera, distortion, turn.copy(), shift.copy())
            seen, _ = cv2.projectPoints(self._corners, *minimum, camera, distortion)
            error = float(np.sqrt(np.mean(np.sum((seen.reshape(4, 2) - corners) ** 2, axis=1))))
            turn, shift = (np.array(part, dtype=np.float64).reshape(3) for part in minimum)
            if np.isfinite(turn).all() and np.isfinite(shift).all() and shift[2] > 0.0:
                solutions.append(Solution(shift, rotation_from_vector(turn), error))
        solutions.sort(key=lambda solution: solution.error)
        return tuple(
            solution
            for rank, solution in enumerate(solutions)
            if all(solution.pose.angle(better.pose) > SAME_ANGLE for better in solutions[:rank])
        )

    def _facing(self, corners: Array, camera: Array, distortion: Array) -> tuple[Array, Array]:
        """Rotation vector and position of a marker that faces the camera where the corners are."""
        rays = cv2.undistortPoints(corners.reshape(-1, 1, 2), camera, distortion).reshape(4, 2)
        right, down = rays[1] + rays[2] - rays[0] - rays[3], rays[2] + rays[3] - rays[0] - rays[1]
        depth = 2.0 * float(self._corners[1, 0] - self._corners[0, 0]) / np.sqrt(np.hypot(*right) * np.hypot(*down))
        z = np.append(rays.mean(axis=0), 1.0)
        position = depth * z
        z = -z / np.linalg.norm(z)
        x = np.append(right, 0.0)
        x -= (x @ z) * z
        x /= np.linalg.norm(x)
        return rotation_vector(np.stack((x, np.cross(z, x), z), axis=1)), position


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
    if image.encoding in _HEADERS:
        return _decompressed(image, data)
    channels, conversion = _RAW[image.encoding]
    if data.size != width * height * channels:
        raise BadImage(f"{data.size} bytes of {image.encoding} data, wanted {width} x {height} x {channels}")
    if conversion is None:
        return data.reshape(height, width)
    grey = cv2.cvtColor(data.reshape(height, width, channels), conversion)
    return grey.astype(np.uint8, copy=False)


def _decompressed(image: CameraImage, data: NDArray[np.uint8]) -> Grey:
    encoding = image.encoding
    header = _HEADERS[encoding](image.data)
    if header is None:
        raise BadImage(f"{data.size} bytes of data are no {encoding} image")
    width, height, bits = header
    if (width, height) != (image.width, image.height):
        raise BadImage(f"{encoding} is {width} x {height}, declared are {image.width} x {image.height}")
    if bits != 8:
        raise BadImage(f"{encoding} has {bits} bits in a channel, wanted 8")
    try:
        grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error as problem:
        raise BadImage(f"{encoding} data cannot be decoded: {problem.err}") from None
    if grey is None:
        raise BadImage(f"{data.size} bytes of {encoding} data cannot be decoded")
    return grey.astype(np.uint8, copy=False)


def _unknown_lens(image: CameraImage) -> str:
    """Why nobody could go by an image's calibration; empty if one can."""
    model, count = image.distortion_model, len(image.distortion)
    low, high = image.width / _ZOOM, image.width * _ZOOM
    if not (low <= image.intrinsics[:2].min() and np.abs(image.intrinsics).max() <= high):
        allowed = (
            f"fx and fy of {low:g} to {high:g} px for a picture that is {image.width} px wide, and cx and cy within"
        )
        return f"intrinsics are {image.intrinsics.tolist()}, wanted are {allowed}"
    if (focal := float(image.intrinsics[:2].min())) < _COARSEST:
        return (
            f"a focal length of {focal:.0f} px sees the panel too coarsely, wanted are {_COARSEST:g}: a larger picture"
        )
    if model in _FISHEYES:
        return f"the camera's model is {model}, a fisheye: {_RECTIFY}"
    if model and model not in _LENSES:
        return f"the camera's model is {model}, known are {' and '.join(_LENSES)}: {_RECTIFY}"
    if count not in _LENSES.get(model, (count,)):
        wanted = " or ".join(map(str, _LENSES[model]))
        return f"the camera's model is {model} with {count} coefficients, wanted are {wanted}: send all of them"
    return ""
