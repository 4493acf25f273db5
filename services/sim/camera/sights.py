"""What there is to see from the robot's head at present."""

from __future__ import annotations

import numpy as np

from services.sim.camera import marker
from services.sim.camera.sight import HEIGHT, WIDTH, Look, Sight, pixels
from services.sim.scene.panel_scene import Carry
from services.sim.scene.world import World
from shared.robot.tiago import CHAIN, FINGERS, HEAD
from shared.spatial import Array, rotation_from_vector

FACING = 0.2
"""Cosine of the angle between a marker's normal and the line of sight below which nobody reads it."""


class Sights:
    """The carrying scenario as the camera sees it.

    Args:
        world: what there is.
        carry: the scenario in it.
        sight: what does not change.
    """

    def __init__(self, world: World, carry: Carry, sight: Sight) -> None:
        self._world = world
        self._carry = carry
        self._sight = sight

    def look(self) -> Look:
        """What the camera would see now."""
        world, panel = self._world, self._carry.panel
        position, rotation = world.camera()
        joints = dict(world.start)
        joints.update(zip(CHAIN, world.arm.physics.positions, strict=True))
        joints.update(zip(HEAD, world.head.position.tolist(), strict=True))
        joints.update(zip(FINGERS, (world.gripper.left, world.gripper.right), strict=True))
        supports = None
        if panel.supported:
            supports = (
                np.array([self._in_base(place) for place in panel.trestles]),
                panel.heading - world.base.yaw,
            )
        return Look(
            position,
            rotation,
            joints,
            self._in_base(panel.body.position),
            self._heading().T.dot(panel.body.rotation),
            supports,
            self._carry.covered,
        )

    def marker_visible(self) -> bool:
        """Whether the whole marker with its margin is in the picture, uncovered and not seen too much from the side.

        That the arm may be in front of it is not looked at.
        """
        if self._carry.covered:
            return False
        position, rotation = self._world.camera()
        body = self._carry.panel.body
        turned = self._heading().T.dot(body.rotation)
        centre = self._in_base(body.position) + turned.dot(self._sight.marker_in_panel)
        to_camera = position - centre
        if turned[:, 2].dot(to_camera) < FACING * np.linalg.norm(to_camera):
            return False
        size = self._sight.marker_size * (1.0 + 2.0 * marker.MARGIN / marker.CELLS)
        corners = centre + marker.corners(size).dot(turned.dot(marker.ROTATION).T)
        columns, rows, depths = pixels(corners, position, rotation).T
        inside = (columns >= 0) & (columns <= WIDTH - 1) & (rows >= 0) & (rows <= HEIGHT - 1)
        return bool((inside & (depths > 0)).all())

    def _heading(self) -> Array:
        return rotation_from_vector((0.0, 0.0, self._world.base.yaw))

    def _in_base(self, point: Array) -> Array:
        base = self._world.base
        return self._heading().T.dot(point - np.array((base.x, base.y, 0.0)))
