"""A free rigid body, integrated here because forces with a known stiffness and damping act on it."""

from __future__ import annotations

import numpy as np

from shared.spatial import GRAVITY, Array, cross, rotation_from_vector

STEADY = 0.5
"""Largest damping [inertia / dt] and stiffness [inertia / dt2] of one of two that act on a body: explicit steps can
follow as long as damping + stiffness / 2 stays below 2 in all."""


class RigidBody:
    """One body under gravity and whatever pushes it.

    Attributes:
        position: of the centre of mass (3,) [m], in world.
        rotation: of the body's principal axes in world (3, 3).
        inertia: principal moments (3,) [kg m2].
        velocity, spin: of the centre of mass (3,) [m/s] and of the body (3,) [rad/s], world axes.

    Args:
        mass: [kg].
        inertia: principal moments (3,) [kg m2].
        position: of the centre of mass (3,) [m], in world.
        rotation: of the principal axes (3, 3), in world.
    """

    def __init__(self, mass: float, inertia: Array, position: Array, rotation: Array) -> None:
        self.mass = mass
        self.inertia = inertia
        self.position: Array = position.copy()
        self.rotation: Array = rotation.copy()
        self.velocity: Array = np.zeros(3)
        self.spin: Array = np.zeros(3)

    def step(self, force: Array, torque: Array, dt: float) -> None:
        """Let ``dt`` [s] pass under a force (3,) [N] and a torque about the centre of mass (3,) [Nm], world axes."""
        acceleration = force / self.mass
        acceleration[2] -= GRAVITY
        self.velocity = self.velocity + acceleration * dt
        rotation = self.rotation
        spin = rotation.T.dot(self.spin)
        change = (rotation.T.dot(torque) - cross(spin, self.inertia * spin)) / self.inertia
        self.spin = rotation.dot(spin + change * dt)
        # The new velocities move the body: explicit springs neither gain nor lose energy over a swing that way.
        self.position = self.position + self.velocity * dt
        self.rotation = rotation_from_vector(self.spin * dt).dot(rotation)

    def followed(self, stiffness: float, damping: float, dt: float) -> tuple[Array, Array]:
        """Angular stiffness (3,) [Nm/rad] and damping (3,) [Nms/rad] about the principal axes, as far as steps follow.

        A light and narrow body in stiff hands would spin up by itself in steps of ``dt`` [s].
        """
        most = STEADY * self.inertia / dt
        return np.minimum(stiffness, most / dt), np.minimum(damping, most)

    def velocities(self, offsets: Array) -> Array:
        """Velocities (n, 3) [m/s] of points of the body at offsets (n, 3) [m] from its centre of mass, world axes."""
        x, y, z = self.spin.tolist()
        turning = np.array(((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)))
        return self.velocity + offsets.dot(turning)
