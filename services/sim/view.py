"""What the head's camera sees: robot, panel and marker, rendered on the processor."""

from __future__ import annotations

import math

import numpy as np
import pybullet
from numpy.typing import NDArray

from services.sim import marker
from services.sim.kinematics import URDF
from services.sim.panel import SUPPORTS
from services.sim.sight import FOCAL_LENGTH, HEIGHT, WIDTH, Look, Sight
from shared.spatial import Array, quaternion

Picture = NDArray[np.uint8]

BACKGROUND = (184, 184, 178)
"""Colour of the floor and of everything else far away. To render a floor takes longer than all the rest."""
NEAR, FAR = 0.05, 8.0
LIGHT_FROM = (-1.0, -2.0, 4.0)
PLATE, INK = 0.0001, 0.0002
"""Heights [m] of the marker's white and of its black above the panel: enough for the renderer to tell them apart."""
_AWAY = (0.0, 0.0, -10.0)
_FLAT = (0.0, 0.0, 0.0, 1.0)


class Renderer:
    """Poses the scene and renders it.

    Args:
        sight: what does not change.
    """

    def __init__(self, sight: Sight) -> None:
        self._sight = sight
        self._client = pybullet.connect(pybullet.DIRECT)
        self._on = {"physicsClientId": self._client}
        self._robot = pybullet.loadURDF(str(URDF), useFixedBase=True, **self._on)
        self._joints = {
            pybullet.getJointInfo(self._robot, joint, **self._on)[1].decode(): joint
            for joint in range(pybullet.getNumJoints(self._robot, **self._on))
        }
        width, height = sight.panel_size[1], 0.03
        self._trestles = [self._box((0.04, 0.8 * width, height), (0.45, 0.36, 0.28, 1.0)) for _ in SUPPORTS]
        self._panel = self._box(sight.panel_size, (0.55, 0.68, 0.82, 1.0))
        cell = sight.marker_size / marker.CELLS
        whole = sight.marker_size + 2.0 * marker.MARGIN * cell
        plate = self._box((whole, whole, PLATE), (1.0, 1.0, 1.0, 1.0))
        # Each part with its place in the marker's frame.
        self._parts = [(plate, np.array((0.0, 0.0, 0.5 * PLATE)))]
        for left, right, lower, upper in marker.strips(sight.marker):
            strip = self._box(((right - left) * cell, (upper - lower) * cell, INK), (0.02, 0.02, 0.02, 1.0))
            centre = np.array((0.5 * (left + right) * cell, 0.5 * (lower + upper) * cell, 0.5 * INK))
            self._parts.append((strip, centre))
        self._projection = pybullet.computeProjectionMatrixFOV(
            math.degrees(2.0 * math.atan(0.5 * HEIGHT / FOCAL_LENGTH)), WIDTH / HEIGHT, NEAR, FAR, **self._on
        )

    def _box(self, size: tuple[float, float, float], colour: tuple[float, ...]) -> int:
        visual = pybullet.createVisualShape(
            pybullet.GEOM_BOX, halfExtents=[0.5 * side for side in size], rgbaColor=colour, **self._on
        )
        return pybullet.createMultiBody(0, -1, visual, _AWAY, **self._on)

    def picture(self, look: Look) -> Picture:
        """What the camera sees (height, width, 3): red, green, blue."""
        self._pose(look)
        forward, down = look.rotation[:, 2], look.rotation[:, 1]
        view = pybullet.computeViewMatrix(
            look.position.tolist(), (look.position + forward).tolist(), (-down).tolist(), **self._on
        )
        _, _, pixels, depth, _ = pybullet.getCameraImage(
            WIDTH,
            HEIGHT,
            view,
            self._projection,
            lightDirection=LIGHT_FROM,
            lightColor=(1, 1, 1),
            lightAmbientCoeff=0.6 * self._sight.light,
            lightDiffuseCoeff=0.4 * self._sight.light,
            lightSpecularCoeff=0.0,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            **self._on,
        )
        picture = np.array(pixels, dtype=np.uint8).reshape(HEIGHT, WIDTH, 4)[:, :, :3]
        nothing = np.reshape(depth, (HEIGHT, WIDTH)) >= 1.0
        picture[nothing] = np.minimum(self._sight.light * np.array(BACKGROUND), 255.0).astype(np.uint8)
        return picture

    def _pose(self, look: Look) -> None:
        for name, position in look.joints.items():
            pybullet.resetJointState(self._robot, self._joints[name], position, **self._on)
        self._place(self._panel, look.panel, look.panel_rotation)
        for index, trestle in enumerate(self._trestles):
            if look.supports is None:
                pybullet.resetBasePositionAndOrientation(trestle, _AWAY, _FLAT, **self._on)
            else:
                places, heading = look.supports
                cosine, sine = math.cos(heading), math.sin(heading)
                turned = np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)))
                self._place(trestle, places[index] - np.array((0.0, 0.0, 0.02)), turned)
        turned = look.panel_rotation.dot(marker.ROTATION)
        centre = look.panel + look.panel_rotation.dot(self._sight.marker_in_panel)
        for part, place in self._parts:
            if look.covered:
                pybullet.resetBasePositionAndOrientation(part, _AWAY, _FLAT, **self._on)
            else:
                self._place(part, centre + turned.dot(place), turned)

    def _place(self, body: int, position: Array, rotation: Array) -> None:
        pybullet.resetBasePositionAndOrientation(
            body, position.tolist(), quaternion(rotation).tolist(), **self._on
        )

    def close(self) -> None:
        """Release the scene."""
        pybullet.disconnect(self._client)
