"""The head camera: takes pictures at its rate while somebody wants them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Protocol

import numpy as np

from services.sim.camera import marker
from services.sim.camera.renderer import Renderer
from services.sim.camera.view import HEIGHT, INTRINSICS, WIDTH, Scenery, View, pixels
from services.sim.robot.sensor_line import SensorLine
from services.sim.scene.panel_scene import PanelScene
from services.sim.scene.world import World
from shared.messages import CameraImage
from shared.robot.tiago import CHAIN, FINGERS, HEAD
from shared.service import Output
from shared.spatial import Array, quaternion, rotation_from_vector
from shared.topics import SENSOR_CAMERA

FACING = 0.2
"""Cosine of the angle between a marker's normal and the line of sight below which nobody reads it."""


class Rendering(Protocol):
    """Renders one picture at a time.

    Attributes:
        complaint: why it does not any more, or "".
    """

    complaint: str

    def begin(self, view: View) -> None:
        """Begin with a picture."""
        ...

    def picture(self) -> bytes | None:
        """The picture begun as a JPEG image, once, when it is ready."""
        ...


class DirectRendering:
    """Renders within the call: for simulated time, in which nothing takes any."""

    complaint = ""

    def __init__(self, scenery: Scenery) -> None:
        self._scenery = scenery
        self._view: View | None = None

    @cached_property
    def _renderer(self) -> Renderer:
        return Renderer(self._scenery)

    def begin(self, view: View) -> None:
        self._view = view

    def picture(self) -> bytes | None:
        view, self._view = self._view, None
        return None if view is None else self._renderer.jpeg(view)


class HeadCamera:
    """Takes pictures of the panel's surroundings, and turns them into messages.

    Args:
        world: what there is.
        scene: the panel in it, and who holds it.
        scenery: what does not change.
        rendering: makes what renders it.
        line: that the messages take.
    """

    def __init__(
        self,
        world: World,
        scene: PanelScene,
        scenery: Scenery,
        rendering: Callable[[Scenery], Rendering],
        line: SensorLine,
    ) -> None:
        self._world = world
        self._panel_scene = scene
        self._scenery = scenery
        self._rendering = rendering(scenery)
        self._line = line
        self._exposed: tuple[View, float] | None = None

    @property
    def complaint(self) -> str:
        """Why there are no pictures any more, or ""."""
        return self._rendering.complaint

    def shots(self, expose: bool, time: float, tick: float, stretch: float) -> list[Output]:
        """The messages of a tick.

        Args:
            expose: whether a picture is to be taken now, unless one is in the making.
            time: simulated [s].
            tick: simulated time [s] since the last call.
            stretch: real time per simulated time.
        """
        if expose and self._exposed is None:
            view = self.view(float(self._line.shift(np.zeros(1))[0]))
            self._exposed = view, time
            self._rendering.begin(view)
        if self._exposed is None or (data := self._rendering.picture()) is None:
            return self._line.send([], tick)
        (view, taken), self._exposed = self._exposed, None
        image = self._line.stick(lambda: _message(view, data))
        return self._line.send([Output(SENSOR_CAMERA, image, late=(time - taken) * stretch)], tick)

    def view(self, brighter: float = 0.0) -> View:
        """What there is to see now; with ``brighter`` [of 255] added to each pixel's values."""
        world, panel = self._world, self._panel_scene.panel
        position, rotation = world.camera()
        joints = dict(world.start)
        joints.update(zip(CHAIN, world.arm.physics.positions, strict=True))
        joints.update(zip(HEAD, world.head.position.tolist(), strict=True))
        joints.update(zip(FINGERS, (world.gripper.left, world.gripper.right), strict=True))
        supports = None
        if panel.supported:
            supports = (np.array([self._in_base(place) for place in panel.trestles]), panel.heading - world.base.yaw)
        return View(
            position,
            rotation,
            joints,
            self._in_base(panel.body.position),
            self._heading().T.dot(panel.body.rotation),
            supports,
            self._panel_scene.covered,
            brighter,
        )

    def marker_visible(self) -> bool:
        """Whether the whole marker with its margin is in the picture, uncovered and not seen too much from the side.

        That the arm may be in front of it is not looked at.
        """
        if self._panel_scene.covered:
            return False
        position, rotation = self._world.camera()
        body = self._panel_scene.panel.body
        turned = self._heading().T.dot(body.rotation)
        centre = self._in_base(body.position) + turned.dot(self._scenery.marker_in_panel)
        to_camera = position - centre
        if turned[:, 2].dot(to_camera) < FACING * np.linalg.norm(to_camera):
            return False
        size = self._scenery.marker_size * (1.0 + 2.0 * marker.MARGIN / marker.CELLS)
        corners = centre + marker.corners(size).dot(turned.dot(marker.ROTATION).T)
        columns, rows, depths = pixels(corners, position, rotation).T
        inside = (columns >= 0) & (columns <= WIDTH - 1) & (rows >= 0) & (rows <= HEIGHT - 1)
        return bool((inside & (depths > 0)).all())

    def _heading(self) -> Array:
        return rotation_from_vector((0.0, 0.0, self._world.base.yaw))

    def _in_base(self, point: Array) -> Array:
        base = self._world.base
        return self._heading().T.dot(point - np.array((base.x, base.y, 0.0)))


def _message(view: View, data: bytes) -> CameraImage:
    return CameraImage(
        WIDTH, HEIGHT, "jpeg", data, np.array(INTRINSICS), np.zeros(5), view.position, quaternion(view.rotation)
    )
