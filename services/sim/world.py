"""The simulated world: the robot and everything that acts on its tool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.sim.arm import Arm
from services.sim.bag import Bag
from services.sim.base import MobileBase, Vector
from services.sim.carry import Carry
from shared.spatial import Array


@dataclass
class _Push:
    """A force [N] and torque [Nm] at the tool, base axes, for so much longer [s]."""

    force: Array
    torque: Array
    left: float


class World:
    """Robot, bag, pushes and, if there is one, the carrying scenario.

    Attributes:
        time: simulated time [s] since the process started.
        contact_force: force (3) [N] that bag and pushes exert on the tool, in world.

    Args:
        step: duration [s] of one physics step.
        carry: the carrying scenario, if it is part of the scene.
    """

    def __init__(self, step: float, carry: Carry | None = None) -> None:
        self.arm = Arm(step)
        self.base = MobileBase()
        self.bag = Bag()
        self.carry = carry
        self.time = 0.0
        self.contact_force = [0.0, 0.0, 0.0]
        self._step = step
        self._pushes: list[_Push] = []

    def reset(self) -> None:
        """Back to the start: base and arm at home, no bag, no push. Time goes on."""
        self.arm.reset()
        if self.carry is not None:
            self.carry.reset()
        self.base = MobileBase()
        self.bag = Bag()
        self._pushes = []
        self.contact_force = [0.0, 0.0, 0.0]

    def load(self, mass: float) -> None:
        """Hang a bag of that total mass [kg] from the tool, or make the one there so heavy; 0 takes it off."""
        self.bag.load(mass, self.base.point(self._tool()))

    def push(self, force: Array, torque: Array, duration: float) -> None:
        """Push the tool with a force (3,) [N] and a torque (3,) [Nm], base axes, for a duration [s]."""
        self._pushes.append(_Push(force, torque, duration))

    def advance(self, twist: Array, base_velocity: Array) -> None:
        """One physics step.

        Args:
            twist: that the arm is told to move its tool with (6,), relative to base.
            base_velocity: of the base: vx, vy [m/s], wz [rad/s] (3,).
        """
        vx, vy, wz = base_velocity.tolist()
        self.base.advance((vx, vy, wz), self._step)
        self.arm.feel(self.base)
        force, torque = self._pull(), None
        if self._pushes:
            total = np.zeros(3)
            for push in self._pushes:
                force = [a + b for a, b in zip(force, push.force.tolist(), strict=True)]
                total += push.torque
                push.left -= self._step
            self._pushes = [push for push in self._pushes if push.left > 0.5 * self._step]
            torque = total.tolist()
        if self.carry is not None:
            self.carry.advance()
        self.arm.advance(twist, force, torque)
        x, y, z = force
        self.contact_force = list(self.base.turned((x, y, z)))
        self.time += self._step

    def _tool(self) -> Vector:
        """Position [m] of the tool in base."""
        x, y, z = self.arm.tool_position.tolist()
        return x, y, z

    def _pull(self) -> list[float]:
        """Force (3) [N] of the bag on the tool in this step, base axes."""
        if not self.bag.present:
            return [0.0, 0.0, 0.0]
        tool = self._tool()
        vx, vy, vz, *_ = self.arm.tool_twist.tolist()
        velocity = self.base.velocity_of(tool, (vx, vy, vz))
        return list(self.base.turned_back(self.bag.step(self.base.point(tool), velocity, self._step)))
