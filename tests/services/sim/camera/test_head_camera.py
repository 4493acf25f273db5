"""The head camera: true to its calibration, only for those who view, and with its faults."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from services.sim.camera import marker
from services.sim.camera.renderer import Renderer
from services.sim.camera.view import INTRINSICS, Scenery, View, pixels
from services.sim.parameters import SimParameters
from services.sim.robot.head import Head
from services.sim.robot.kinematics import CARRY_HOME
from shared import topics
from shared.messages import CameraImage, HeadCommand
from shared.parameters import Refused
from shared.spatial import quaternion, rotation_from_vector, rotation_matrix
from tests.services.sim.rig import Rig

SCENERY = SimParameters().scenery()


def grey(image: CameraImage) -> np.ndarray:
    return np.array(Image.open(io.BytesIO(image.data)).convert("L"), dtype=float)


def marker_corners(position: np.ndarray, rotation: np.ndarray, scenery: Scenery = SCENERY) -> np.ndarray:
    """Corners (4, 3) of the black square of a panel at a pose."""
    turned = rotation @ marker.ROTATION
    return position + rotation @ scenery.marker_in_panel + marker.corners(scenery.marker_size) @ turned.T


def whole_polygon(corners: np.ndarray) -> np.ndarray:
    """Which pixels' middles (480, 640) are inside a quadrangle of columns and rows (4, 2)."""
    columns, rows = np.meshgrid(np.arange(640.0), np.arange(480.0))
    inside = np.ones((480, 640), dtype=bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= (x1 - x0) * (rows - y0) - (y1 - y0) * (columns - x0) >= 0.0
    return inside


def error_of(picture: np.ndarray, corners: np.ndarray) -> float:
    """Distance [px] between the middles of a black square as it is in a picture and as it should be.

    What is inside depends on the marker, and is painted black.
    """
    centre = corners.mean(axis=0)
    picture = picture.copy()
    picture[whole_polygon(centre + 4.0 / 6.0 * (corners - centre))] = 0.0
    found = (picture < 60) & whole_polygon(centre + 1.2 * (corners - centre))
    places = [[axis.mean() for axis in np.nonzero(mask)] for mask in (whole_polygon(corners), found)]
    return float(np.linalg.norm(np.subtract(*places)))


@pytest.fixture(scope="module")
def renderer():  # type: ignore[no-untyped-def]
    renderer = Renderer(SCENERY)
    yield renderer
    renderer.close()


@pytest.mark.parametrize(
    ("place", "turn"),
    [
        ((1.17, -0.39, 0.78), (0, 0, 0)),
        ((1.10, -0.20, 0.70), (0.0, 0.0, 0.3)),
        ((1.25, -0.55, 0.90), (0.1, -0.15, -0.2)),
        ((1.17, -0.39, 0.60), (-0.2, 0.1, 0.0)),
    ],
)
def test_points_are_where_the_calibration_says(
    renderer: Renderer, place: tuple[float, ...], turn: tuple[float, ...]
) -> None:
    head = Head(CARRY_HOME)
    head.position = np.array((-0.45, -0.5))
    position, rotation = head.camera(0.22)
    panel, turned = np.array(place), rotation_from_vector(turn)
    view = View(position, rotation, dict(CARRY_HOME), panel, turned, None, False)
    picture = renderer.picture(view).mean(axis=2)
    corners = pixels(marker_corners(panel, turned), position, rotation)[:, :2]
    assert error_of(picture, corners) < 0.5
    # And each corner: black within, white beyond.
    outwards = (corners - corners.mean(axis=0)) / np.linalg.norm(corners - corners.mean(axis=0), axis=1)[:, None]
    for corner, out in zip(corners, outwards, strict=True):
        inside, outside = np.round(corner - 2.5 * out).astype(int), np.round(corner + 2.5 * out).astype(int)
        assert picture[inside[1], inside[0]] < 60 < 150 < picture[outside[1], outside[0]]


def test_noise_is_as_strong_as_stated_and_the_same_for_one_seed() -> None:
    position, rotation = Head(CARRY_HOME).camera(0.22)
    view = View(position, rotation, dict(CARRY_HOME), np.array((1.17, -0.39, 0.78)), np.eye(3), None, False)
    pictures = []
    for noise, seed in ((0.0, 1), (6.0, 1), (6.0, 1), (6.0, 2)):
        renderer = Renderer(replace(SCENERY, noise=noise, seed=seed))
        pictures.append(renderer.picture(view).astype(float))
        renderer.close()
    clean, noisy, again, other = pictures
    # Away from black and white, where it is cut off.
    grain = (noisy - clean)[np.abs(clean - 127.0) < 90.0]
    assert grain.std() == pytest.approx(6.0, rel=0.05) and abs(grain.mean()) < 1.0
    assert np.array_equal(noisy, again) and not np.array_equal(noisy, other)


class Watched(Rig):
    """The carrying scenario with its head turned to the panel."""

    def __init__(self, **parameters: object) -> None:
        super().__init__(scene="carry", **parameters)
        self.look(-0.45, -0.5)

    def look(self, pan: float, tilt: float) -> None:
        self.stack.client.publish(topics.COMMAND_HEAD, HeadCommand(pan, tilt))
        self.run(0.6)

    @property
    def picture(self) -> np.ndarray:
        return grey(self.last(topics.SENSOR_CAMERA))

    def seen(self) -> np.ndarray:
        """Corners (4, 2) [px] of the marker by the message's own calibration."""
        image, world = self.last(topics.SENSOR_CAMERA), self.last(topics.SIM_WORLD)
        base = self.last(topics.STATE_BASE)
        heading = rotation_from_vector((0, 0, base.yaw))
        corners = marker_corners(world.panel.position, rotation_matrix(world.panel.orientation))
        corners = (corners - np.array((*base.position, 0.0))) @ heading
        return pixels(corners, image.position, rotation_matrix(image.orientation))[:, :2]


@pytest.fixture(scope="module")
def rig() -> Watched:
    return Watched()


def test_images_come_at_their_rate_with_the_calibration(rig: Watched) -> None:
    before = len(rig.received["sensor/camera"])
    rig.run(1.0)
    assert len(rig.received["sensor/camera"]) - before == pytest.approx(10, abs=1)
    image = rig.last(topics.SENSOR_CAMERA)
    assert (image.width, image.height, image.encoding) == (640, 480, "jpeg")
    assert image.intrinsics == pytest.approx(INTRINSICS)
    assert image.intrinsics[0] == pytest.approx(320 / np.tan(np.radians(63.0 / 2.0)))
    assert not image.distortion.any()
    assert Image.open(io.BytesIO(image.data)).size == (640, 480)


def test_the_marker_is_where_the_message_says(rig: Watched) -> None:
    assert rig.last(topics.SIM_WORLD).marker_visible
    corners = rig.seen()
    picture = rig.picture
    assert error_of(picture, corners) < 1.0


def test_it_turns_away_and_back(rig: Watched) -> None:
    rig.look(0.6, -0.5)
    assert not rig.last(topics.SIM_WORLD).marker_visible
    joints = rig.last(topics.STATE_JOINTS)
    assert joints.position[joints.name.index("head_1_joint")] == pytest.approx(0.6)
    rig.look(100.0, -100.0)
    joints = rig.last(topics.STATE_JOINTS)
    assert joints.position[joints.name.index("head_1_joint")] == pytest.approx(1.309)
    assert joints.position[joints.name.index("head_2_joint")] == pytest.approx(-1.047)
    rig.look(-0.45, -0.5)
    assert rig.last(topics.SIM_WORLD).marker_visible


@pytest.mark.parametrize("uncover", [{"command": "reset"}, {"command": "cover_marker", "covered": False}])
def test_covered_it_is_gone_until_it_is_uncovered(rig: Watched, uncover: dict[str, object]) -> None:
    corners = rig.seen()
    rig.ask(command="cover_marker")
    rig.run(0.3)
    assert not rig.last(topics.SIM_WORLD).marker_visible
    assert rig.picture[whole_polygon(corners)].min() > 60
    with pytest.raises(Refused, match="covered is 'no', wanted true or false"):
        rig.ask(command="cover_marker", covered="no")
    rig.ask(**uncover)
    rig.look(-0.45, -0.5)
    assert rig.last(topics.SIM_WORLD).marker_visible
    assert rig.picture[whole_polygon(corners)].min() < 60


def test_no_two_pictures_are_the_same_but_those_of_a_stuck_camera_which_repeats_its_pose_too(rig: Watched) -> None:
    pictures = [received.message.data for received in rig.received["sensor/camera"][-5:]]
    assert len(set(pictures)) == 5, "although nothing moves"
    rig.ask(command="fault", target="camera", kind="stuck")
    rig.run(0.5)
    assert len({received.message.data for received in rig.received["sensor/camera"][-3:]}) == 1
    pose = rig.last(topics.SENSOR_CAMERA).orientation
    rig.look(0.3, -0.5)
    assert rig.last(topics.SENSOR_CAMERA).orientation == pytest.approx(pose)
    rig.ask(command="fault", target="camera", kind="ok")
    rig.look(-0.45, -0.5)
    assert rig.last(topics.SENSOR_CAMERA).orientation == pytest.approx(pose, abs=1e-6)


def test_a_biased_camera_is_brighter_or_darker_up_to_white_and_black(rig: Watched) -> None:
    right = rig.picture
    for bias in (40.0, -40.0, 255.0, -255.0):
        rig.ask(command="fault", target="camera", kind="bias", value=bias)
        rig.run(0.3)
        # What JPEG blurs at the edges of the marker counts for little in the whole.
        assert rig.picture.mean() == pytest.approx(np.clip(right + bias, 0, 255).mean(), abs=1.5)
    rig.ask(command="fault", target="camera", kind="ok")
    rig.run(0.3)
    assert rig.picture.mean() == pytest.approx(right.mean(), abs=0.5)
    for value in (None, 256.0, [1.0] * 3, True):
        with pytest.raises(Refused, match=r"value is .*, wanted (a number|-255 to 255 of 255)"):
            rig.ask(command="fault", target="camera", kind="bias", value=value)


def test_in_the_dark_there_is_nothing_to_see() -> None:
    rig = Watched(light=0.0)
    assert rig.picture.max() < 30


def test_the_base_moves_and_the_marker_is_still_where_the_message_says() -> None:
    rig = Watched(base_type="omni")
    rig.drive((-0.05, 0.0, -0.1), 1.0)
    rig.run(1.0)
    corners, picture = rig.seen(), rig.picture
    assert error_of(picture, corners) < 1.0
    pose = rig.last(topics.SENSOR_CAMERA)
    head = rig.simulator.world.camera()
    assert pose.position == pytest.approx(head[0], abs=1e-6)
    assert pose.orientation == pytest.approx(quaternion(head[1]), abs=1e-6)
