"""A bag on a rope that hangs from the tool, swings, and can be set down on the floor.

The bag is a point mass; the rope pulls like a spring with a damper and never pushes. Both are computed here and not in
the physics engine, whose contacts and constraints cannot be given a stiffness and a damping.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from shared.spatial import GRAVITY

ROPE_LENGTH = 0.35
"""Length [m] of the slack rope from the tool to the top of the bag."""
BAG_LENGTH = 0.25
"""Distance [m] from the top of the bag, where it is held, to its bottom."""
ROPE_STIFFNESS = 3000.0
"""[N/m]: 20 N stretch it by 7 mm."""
ROPE_DAMPING_RATIO = 0.4
SWING_DAMPING = 0.3
"""Deceleration per speed [1/s] of a swinging bag."""
FLOOR_STIFFNESS = 4000.0
"""[N/m] of bag and floor together."""
FLOOR_DAMPING_RATIO = 0.7
FLOOR_GRIP = 20.0
"""Deceleration per speed [1/s] of a bag that is dragged along the floor."""
HANDOVER = 0.5
"""Time [s] over which the person who hangs the bag, or takes it off, lets go of or takes over its weight."""
LIGHTEST = 0.05
"""Mass [kg] of the lightest bag; of the heaviest see `shared.sim_messages`."""

Vector = tuple[float, float, float]


@dataclass
class _Handover:
    """The lift [N] of a person's hand, going smoothly from one value to another."""

    start: float
    end: float
    elapsed: float = 0.0

    def lift(self, dt: float) -> float:
        self.elapsed += dt
        share = min(self.elapsed / HANDOVER, 1.0)
        return self.start + (self.end - self.start) * share * share * (3.0 - 2.0 * share)

    @property
    def over(self) -> bool:
        return self.elapsed >= HANDOVER


class Bag:
    """At most one bag; ``mass`` 0 [kg] means that there is none.

    Args:
        down: unit vector of gravity in world.
    """

    def __init__(self, down: Vector = (0.0, 0.0, -1.0)) -> None:
        self._down = down
        self.mass = 0.0
        self._position = [0.0, 0.0, 0.0]
        self._velocity = [0.0, 0.0, 0.0]
        self._hand = _Handover(0.0, 0.0, HANDOVER)
        self._leaving = False

    @property
    def present(self) -> bool:
        """Whether a bag hangs from the tool or stands on the floor below it."""
        return self.mass > 0.0

    @property
    def height(self) -> float:
        """Height [m] of the bag's bottom above the floor."""
        return self._position[2] - BAG_LENGTH

    @property
    def top(self) -> Vector:
        """Where the rope is tied to the bag [m], in world."""
        x, y, z = self._position
        return x, y, z

    def load(self, mass: float, tool: Vector) -> None:
        """Make the bag's total mass ``mass`` [kg]; 0 takes it off.

        Nothing jumps: a person's hand carries what is added or taken away at first, and what it carries changes
        smoothly within ``HANDOVER``.
        """
        if not self.present:
            if mass == 0.0:
                return
            self._position = [tool[0], tool[1], tool[2] - ROPE_LENGTH]
            self._velocity = [0.0, 0.0, 0.0]
            # The hand that took the last bag off has gone with it.
            self._hand = _Handover(0.0, 0.0, HANDOVER)
        carried = self._hand.lift(0.0)
        if mass == 0.0:
            self._hand = _Handover(carried, self.mass * GRAVITY)
        else:
            self._hand = _Handover(carried + (mass - self.mass) * GRAVITY, 0.0)
            self.mass = mass
        self._leaving = mass == 0.0

    def step(self, tool: Vector, tool_velocity: Vector, dt: float) -> Vector:
        """Move the bag for ``dt`` [s] and return the force (3,) [N, world] that the rope exerts on the tool."""
        if not self.present:
            return 0.0, 0.0, 0.0
        pull = self._rope(tool, tool_velocity)
        weight = self.mass * GRAVITY - self._hand.lift(dt)
        floor, drag = self._floor()
        drag = max(drag, SWING_DAMPING)
        x, y, z = self._down
        forces = (weight * x - pull[0], weight * y - pull[1], floor + weight * z - pull[2])
        for axis, force in enumerate(forces):
            acceleration = force / self.mass
            slowing = 1.0 / (1.0 + drag * dt) if axis < 2 else 1.0
            self._velocity[axis] = (self._velocity[axis] + acceleration * dt) * slowing
            self._position[axis] += self._velocity[axis] * dt
        if self._leaving and self._hand.over:
            self.mass = 0.0
        return pull

    def _rope(self, tool: Vector, tool_velocity: Vector) -> Vector:
        """Force [N] on the tool."""
        away = [self._position[axis] - tool[axis] for axis in range(3)]
        length = math.sqrt(away[0] ** 2 + away[1] ** 2 + away[2] ** 2)
        stretch = length - ROPE_LENGTH
        if stretch <= 0.0:
            return 0.0, 0.0, 0.0
        along = [component / length for component in away]
        rate = sum(along[axis] * (self._velocity[axis] - tool_velocity[axis]) for axis in range(3))
        damping = 2.0 * ROPE_DAMPING_RATIO * math.sqrt(ROPE_STIFFNESS * self.mass)
        tension = max(0.0, ROPE_STIFFNESS * stretch + damping * rate)
        return tension * along[0], tension * along[1], tension * along[2]

    def _floor(self) -> tuple[float, float]:
        """Upward force [N] of the floor and its deceleration per speed [1/s] along it."""
        depth = -self.height
        if depth <= 0.0:
            return 0.0, 0.0
        damping = 2.0 * FLOOR_DAMPING_RATIO * math.sqrt(FLOOR_STIFFNESS * self.mass)
        return max(0.0, FLOOR_STIFFNESS * depth - damping * self._velocity[2]), FLOOR_GRIP
