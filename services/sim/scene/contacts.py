"""Contact at points: an elastic normal force, and friction that sticks before it slips.

The physics engine's contacts take no stiffness at their word; these do, and the tests measure it.
"""

from __future__ import annotations

import numpy as np

from shared.spatial import Array

DAMPING_RATIO = 0.5  # [1] of what bounces on one point


class PointContacts:
    """Points that may touch one surface.

    Args:
        count: number of points.
        stiffness: of each [N/m], along the normal and across it.
        mass: [kg] that bounces on each, which sets the damping.
        friction: coefficient.
    """

    def __init__(self, count: int, stiffness: float, mass: float, friction: float) -> None:
        self._stiffness = stiffness
        self._damping = 2.0 * DAMPING_RATIO * (stiffness * mass) ** 0.5
        self._friction = friction
        self._none = np.zeros((count, 3))
        self._stretch = self._none
        self._touching = False

    def forces(self, depth: Array, normal: Array, velocity: Array, dt: float) -> Array | None:
        """Forces (n, 3) [N] on the points; None if nothing touches.

        Args:
            depth: how far each point is inside the surface (n,) [m].
            normal: outward normal of the surface (3,).
            velocity: of the points relative to the surface (n, 3) [m/s].
            dt: time [s] since the last call.
        """
        touching = depth > 0.0
        if not touching.any():
            if self._touching:
                self._stretch = self._none
                self._touching = False
            return None
        self._touching = True
        leaving = velocity.dot(normal)
        pressure = np.maximum(self._stiffness * depth - self._damping * leaving, 0.0) * touching
        sliding = velocity - leaving[:, None] * normal
        stretch = self._stretch + sliding * dt
        stretch = (stretch - stretch.dot(normal)[:, None] * normal) * touching[:, None]
        drag = self._stiffness * stretch + self._damping * sliding
        size = np.sqrt(np.einsum("ij,ij->i", drag, drag))
        share = np.minimum(self._friction * pressure / np.maximum(size, 1e-12), 1.0)[:, None]
        # A point that slips drags its spring along.
        slips = share < 1.0
        self._stretch = np.where(slips, share * drag / self._stiffness, stretch)
        forces: Array = pressure[:, None] * normal - share * drag
        return forces
