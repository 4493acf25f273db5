"""The simulated world: the arm and everything that acts on its tool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.sim.arm import Arm
from services.sim.bag import Bag
from shared.spatial import Array


@dataclass
class _Push:
    """A force [N] and torque [Nm] at the tool, base axes, for so much longer [s]."""

    force: Array
    torque: Array
    left: float


class World:
    """Arm, bag and pushes.

    Attributes:
        time: simulated time [s] since the process started.
        contact_force: force (3) [N] that bag and pushes exert on the tool, base axes.

    Args:
        step: duration [s] of one physics step.
    """

    def __init__(self, step: float) -> None:
        self.arm = Arm(step)
        self.bag = Bag()
        self.time = 0.0
        self.contact_force = [0.0, 0.0, 0.0]
        self._step = step
        self._pushes: list[_Push] = []

    def reset(self) -> None:
        """Back to the start: the arm at home, no bag, no push. Time goes on."""
        self.arm.reset()
        self.bag = Bag()
        self._pushes = []
        self.contact_force = [0.0, 0.0, 0.0]

    def load(self, mass: float) -> None:
        """Hang a bag of that total mass [kg] from the tool, or make the one there so heavy; 0 takes it off."""
        x, y, z = self.arm.tool_position.tolist()
        self.bag.load(mass, (x, y, z))

    def push(self, force: Array, torque: Array, duration: float) -> None:
        """Push the tool with a force (3,) [N] and a torque (3,) [Nm], base axes, for a duration [s]."""
        self._pushes.append(_Push(force, torque, duration))

    def advance(self, twist: Array) -> None:
        """One physics step, the arm being told to move its tool with a twist (6,)."""
        force, torque = self._pull(), None
        if self._pushes:
            total = np.zeros(3)
            for push in self._pushes:
                force = [a + b for a, b in zip(force, push.force.tolist(), strict=True)]
                total += push.torque
                push.left -= self._step
            self._pushes = [push for push in self._pushes if push.left > 0.5 * self._step]
            torque = total.tolist()
        self.arm.advance(twist, force, torque)
        self.contact_force = force
        self.time += self._step

    def _pull(self) -> list[float]:
        """Force (3) [N] of the bag on the tool in this step."""
        if not self.bag.present:
            return [0.0, 0.0, 0.0]
        x, y, z = self.arm.tool_position.tolist()
        vx, vy, vz, *_ = self.arm.tool_twist.tolist()
        return list(self.bag.step((x, y, z), (vx, vy, vz), self._step))
