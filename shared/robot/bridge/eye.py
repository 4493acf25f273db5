"""The camera of a bridge: images with their calibration, while somebody wants them."""

from __future__ import annotations

from collections.abc import Iterator

from shared.clock import seconds
from shared.messages import DISTORTION_SIZES, CameraImage
from shared.robot.bridge.state import RobotState
from shared.robot.far_side import Calibration, FarSide, Heard, Picture
from shared.robot.profile_tables import Camera
from shared.service import Output
from shared.spatial import Array, quaternion
from shared.topics import SENSOR_CAMERA

_FISHEYE = "equidistant"


class Eye:
    """Publishes images, and looks at one at the start to see what the camera is like.

    Args:
        camera: as the profile has it.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._number = 0
        self._sent: int | None = None
        self._lines: tuple[str, ...] = ()
        self._seen = False

    def look(self, far: FarSide, state: RobotState, wanted: bool, now: int) -> list[Output]:
        """The newest image, if it is new, wanted and due."""
        pair = far.picture(wanted or not self._seen)
        if pair is None or pair[0].number == self._number:
            return []
        picture, calibration = pair
        self._number, self._seen = picture.number, True
        self._lines = tuple(self._wrong(picture.message, calibration.message))
        pose = state.camera(picture.stamp)
        due = self._sent is None or seconds(now - self._sent) > 0.9 / SENSOR_CAMERA.rate
        if pose is None or not (wanted and due) or not _usable(picture.message, calibration.message):
            return []
        self._sent = now
        place, rotation, behind = pose
        image = _image(picture, calibration, place, quaternion(rotation))
        return [Output(SENSOR_CAMERA, image, late=max(behind, seconds(now - picture.arrival)))]

    def lines(self) -> tuple[str, ...]:
        """What is not as expected, one line each."""
        return self._lines

    def _wrong(self, picture: Picture, calibration: Calibration) -> Iterator[str]:
        camera, count = self._camera, len(calibration.distortion)
        if picture.encoding != camera.encoding:
            yield (
                f"{camera.image} comes in {picture.encoding}, the profile says {camera.encoding}: it is passed on as "
                "what it is"
            )
        if not _of_one_size(picture, calibration):
            yield (
                f"{camera.info} is of {calibration.width}x{calibration.height} pixels, the image has "
                f"{picture.width}x{picture.height}: no image is passed on"
            )
        if not _known(calibration):
            yield f"{camera.info}: {count} coefficients of {calibration.model} are of no use: no image is passed on"
        elif count > 5:
            yield f"{camera.info} has {count} coefficients, of {calibration.model}: they are passed on as they are"


def _known(calibration: Calibration) -> bool:
    return calibration.model != _FISHEYE and len(calibration.distortion) in DISTORTION_SIZES


def _of_one_size(picture: Picture, calibration: Calibration) -> bool:
    return (picture.width, picture.height) == (calibration.width, calibration.height)


def _usable(picture: Picture, calibration: Calibration) -> bool:
    return _known(calibration) and _of_one_size(picture, calibration)


def _image(picture: Heard[Picture], calibration: Heard[Calibration], place: Array, orientation: Array) -> CameraImage:
    shot, lens = picture.message, calibration.message
    return CameraImage(
        width=shot.width,
        height=shot.height,
        encoding=shot.encoding,
        data=shot.data,
        intrinsics=lens.intrinsics,
        distortion=lens.distortion,
        position=place,
        orientation=orientation,
        distortion_model=lens.model,
    )
