"""A person's two hands at the panel's far edge: as stiff as human arms, and no stronger."""

from __future__ import annotations

import math

import numpy as np

from services.sim.scene.panel import Panel
from shared.spatial import Array, cross, rotation_from_vector, rotation_vector

STIFFNESS, ANGULAR_STIFFNESS = 500.0, 40.0
"""[N/m, Nm/rad] Of the arms, as in the quick model of the carry (docs/task.md); both grow and fall together."""
DAMPING_RATIO = 0.7  # [1] of the arms, as in the quick model of the carry
INSET = 0.03  # [m] from the edge, where the hands hold it; an assumption: half a palm


class Hands:
    """What the hands do to the panel follows from where they want to be and where it is.

    Attributes:
        holding: whether they hold the panel.
        position, rotation: where they want to be: (3,) [m] and (3, 3), in world.
        lifting: force [N] upwards that they add to what follows from that.
        force, torque: that they exert on the panel at ``place`` (3,) [N], (3,) [Nm], in world, in the last step.
        strain: force [N] and torque [Nm] of their stiffness alone: what tells a person that something resists.
        place: where they are (3,) [m], in world.

    Args:
        strength: largest force [N].
        torque_strength: largest torque [Nm].
        stiffness: of the arms [N/m].
    """

    def __init__(self, strength: float, torque_strength: float, stiffness: float = STIFFNESS) -> None:
        self._stiffness, self._angular_stiffness = stiffness, ANGULAR_STIFFNESS * stiffness / STIFFNESS
        self._strength = strength
        self._torque_strength = torque_strength
        self.holding = False
        self.lifting = 0.0
        self.position: Array = np.zeros(3)
        self.rotation: Array = np.eye(3)
        self.place: Array = np.zeros(3)
        self.let_go()

    def take_hold(self, panel: Panel) -> None:
        """Take hold of the panel where it is, at ease."""
        self.holding = True
        self.position = self._on(panel)
        self.rotation = panel.body.rotation.copy()
        self._before = self.position, self.rotation

    def wish(self, panel: Panel) -> tuple[Array, Array]:
        """Where the hands want to be (3,) [m] and how the panel is to be turned (3, 3), in world.

        Hands that have let go want it as it is.
        """
        return (self.position, self.rotation) if self.holding else (self.place, panel.body.rotation)

    def ease(self, panel: Panel, share: float) -> None:
        """Bring where the hands want to be nearer to where they are, by a share [0, 1] of the way."""
        self.lifting *= 1.0 - share
        self.position = self.position + share * (self._on(panel) - self.position)
        left = rotation_vector(panel.body.rotation.dot(self.rotation.T))
        self.rotation = rotation_from_vector(share * left).dot(self.rotation)

    def let_go(self) -> None:
        """Let go of the panel."""
        self.holding = False
        self.lifting = 0.0
        self.force: Array = np.zeros(3)
        self.torque: Array = np.zeros(3)
        self.strain = (0.0, 0.0)

    def step(self, panel: Panel, dt: float) -> tuple[Array, Array]:
        """Force (3,) [N] and torque about its centre (3,) [Nm] on the panel, world axes; then ``dt`` [s] pass."""
        body = panel.body
        self.place = self._on(panel)
        if not self.holding:
            return self.force, self.torque
        arm = self.place - body.position
        damping, angular = self._damping(panel)
        stiff, damped = body.followed(self._angular_stiffness, angular, dt)
        wanted = (self.position - self._before[0]) / dt
        turning = rotation_vector(self.rotation.dot(self._before[1].T)) / dt
        self._before = self.position, self.rotation
        pull = self._stiffness * (self.position - self.place)
        turned = body.rotation
        twist = turned.dot(stiff * turned.T.dot(rotation_vector(self.rotation.dot(turned.T))))
        self.strain = float(np.linalg.norm(pull)), float(np.linalg.norm(twist))
        pull = pull + damping * (wanted - body.velocity - cross(body.spin, arm))
        pull[2] += self.lifting
        twist = twist + turned.dot(damped * turned.T.dot(turning - body.spin))
        self.force = bounded(pull, self._strength)
        self.torque = bounded(twist, self._torque_strength)
        return self.force, self.torque + cross(arm, self.force)

    @staticmethod
    def _on(panel: Panel) -> Array:
        return panel.body.position + (panel.half[0] - INSET) * panel.body.rotation[:, 0]

    def _damping(self, panel: Panel) -> tuple[float, float]:
        """[Ns/m, Nms/rad], for the half of the panel that each end carries."""
        mass = 0.5 * panel.body.mass
        inertia = mass * panel.half[0] ** 2 / 3.0
        return (
            2.0 * DAMPING_RATIO * math.sqrt(self._stiffness * mass),
            2.0 * DAMPING_RATIO * math.sqrt(self._angular_stiffness * inertia),
        )


def bounded(vector: Array, largest: float) -> Array:
    """A vector no longer than ``largest``, in its direction."""
    size = math.sqrt(float(vector.dot(vector)))
    return vector if size <= largest else vector * (largest / size)
