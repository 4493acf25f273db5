"""The panel of foam insulation: a rigid body on its supports, on the ground, or in somebody's hands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.sim.scene.contacts import PointContacts
from services.sim.scene.rigid_body import RigidBody
from shared.spatial import GRAVITY, Array, rotation_from_vector

SUPPORTS = (-0.25, 0.25)  # of the panel's length: where the two trestles stand, from its centre
SUPPORT_WIDTH = 0.35  # of the panel's width: a trestle's two points of contact, from the panel's centre line
CLEARED = 0.05
"""[m] How far the panel is lifted when the supports are taken away: turned by 90 degrees it would hit them."""


@dataclass(frozen=True)
class PanelSpec:
    """What the panel is like.

    Attributes:
        size: length along x, width along y, thickness along z (3,) [m], in its own axes.
        mass: [kg].
        friction: of the foam on ground and supports.
        stiffness: [N/m] of the foam that stands on an edge or lies on a face.
        near_edge: middle of the edge towards the robot (3,) [m], in world, as it lies on its supports.
        yaw: of the panel and its supports about the vertical through there [rad].
    """

    size: tuple[float, float, float]
    mass: float
    friction: float
    stiffness: float
    near_edge: tuple[float, float, float]
    yaw: float = 0.0


class Panel:
    """The panel; its origin is its centre. On its supports its x axis leads away from the robot, its z axis up.

    Attributes:
        body: position, rotation and motion.
        half: half its size (3,) [m].
        supported: whether the supports still stand.
        trestles: where they stand: the middle of their upper edges (2, 3) [m], in world.
        heading: of the trestles [rad].
    """

    def __init__(self, spec: PanelSpec) -> None:
        self.half: Array = np.array(spec.size) / 2.0
        length, width, thickness = spec.size
        squares = np.array((width**2 + thickness**2, length**2 + thickness**2, length**2 + width**2))
        lying = rotation_from_vector((0.0, 0.0, spec.yaw))
        centre = np.array(spec.near_edge) + length / 2.0 * lying[:, 0]
        self.body = RigidBody(spec.mass, spec.mass / 12.0 * squares, centre, lying)
        signs = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        self._corners = signs * self.half
        # Lying on a face or standing on an edge it rests on four corners.
        share = spec.stiffness / 4.0, spec.mass / 4.0, spec.friction
        self._ground = PointContacts(8, *share)
        self._trestles = PointContacts(4, *share)
        # So that it lies still, pressed into them by its weight, from the start on.
        depth = thickness / 2.0 - spec.mass * GRAVITY / spec.stiffness
        points = [(x * length, y * SUPPORT_WIDTH * width, -depth) for x in SUPPORTS for y in (-1.0, 1.0)]
        self._points = centre + np.array(points).dot(lying.T)
        middles = [(along * length, 0.0, -thickness / 2.0) for along in SUPPORTS]
        self.trestles: Array = centre + np.array(middles).dot(lying.T)
        self.heading = spec.yaw
        self._clear = centre[2] + CLEARED
        self.supported = True

    def step(self, force: Array, torque: Array, dt: float) -> None:
        """Let ``dt`` [s] pass; a force (3,) [N] and a torque about the centre (3,) [Nm] of others act, world axes."""
        body = self.body
        force, torque = force.copy(), torque.copy()
        if body.position[2] < self._reach():
            offsets = self._corners.dot(body.rotation.T)
            depth = -(body.position[2] + offsets[:, 2])
            self._add(self._ground, depth, _UP, offsets, 1.0, force, torque, dt)
        if self.supported:
            self._rest(force, torque, dt)
        body.step(force, torque, dt)

    def _reach(self) -> float:
        """Height [m] of the centre above which no corner can touch the ground."""
        return float(np.abs(self.body.rotation[2]).dot(self.half))

    def _rest(self, force: Array, torque: Array, dt: float) -> None:
        """Add what the supports do, whose points may be inside the panel."""
        body = self.body
        if body.position[2] > self._clear:
            self.supported = False
            return
        offsets = self._points - body.position
        inside = offsets.dot(body.rotation)
        depth = inside[:, 2] + self.half[2]
        beside = (np.abs(inside[:, :2]) > self.half[:2]).any(axis=1) | (inside[:, 2] > 0.0)
        depth[beside] = 0.0
        self._add(self._trestles, depth, -body.rotation[:, 2], offsets, -1.0, force, torque, dt)

    def _add(
        self,
        contacts: PointContacts,
        depth: Array,
        normal: Array,
        offsets: Array,
        side: float,
        force: Array,
        torque: Array,
        dt: float,
    ) -> None:
        """Add to force and torque what contacts at ``offsets`` (n, 3) [m] from the centre do.

        ``side`` is 1 if the points belong to the panel, -1 if they belong to the world and the surface to the panel.
        """
        forces = contacts.forces(depth, normal, side * self.body.velocities(offsets), dt)
        if forces is None:
            return
        forces = side * forces
        force += forces.sum(axis=0)
        torque += np.cross(offsets, forces).sum(axis=0)


_UP = np.array((0.0, 0.0, 1.0))
