"""How simulated time is cut into ticks, and whether the machine keeps up."""

from __future__ import annotations

import math

KEEPS_UP = 0.95  # of the wanted pace, below which the simulation says that it cannot keep up


class Ticks:
    """Rates of the outputs on a common grid of ticks that the force-torque sensor's rate divides.

    Attributes:
        rate: ticks per simulated second [Hz].
        substeps: physics steps per tick.
        step: duration [s] of a physics step.

    Args:
        ft_rate: exact rate [Hz] of the force-torque sensor.
        joint_rate: the other fast rate [Hz]; ticks are at least as frequent.
        physics_rate: least rate [Hz] of physics steps.
    """

    def __init__(self, ft_rate: float, joint_rate: float, physics_rate: float) -> None:
        self.rate = ft_rate * math.ceil(joint_rate / ft_rate - 1e-9)
        self.substeps = math.ceil(physics_rate / self.rate - 1e-9)
        self.step = 1.0 / (self.rate * self.substeps)
        self._count = 0

    def advance(self) -> None:
        """Count one tick."""
        self._count += 1

    def due(self, rate: float) -> bool:
        """Whether an output of that rate [Hz] is due at the present tick."""
        share = rate / self.rate
        return math.floor(self._count * share + 1e-6) > math.floor((self._count - 1) * share + 1e-6)


class Pace:
    """Compares the pace of the last second or so with the wanted one.

    Args:
        settings: that lower the pace or what it costs, in words.
    """

    def __init__(self, settings: str = "real_time_factor, ft_rate or physics_rate") -> None:
        self._settings = settings
        self._elapsed = 0.0
        self._planned = 0.0
        self.share = 1.0

    def add(self, elapsed: float, planned: float) -> None:
        """Account for a tick that took ``elapsed`` [s] and should have taken ``planned`` [s]."""
        self._elapsed += elapsed
        self._planned += planned
        if self._elapsed >= 1.0:
            self.share = self._planned / self._elapsed
            self._elapsed = self._planned = 0.0

    @property
    def complaint(self) -> str:
        """What to tell the user; empty while the machine keeps up."""
        if self.share >= KEEPS_UP:
            return ""
        return f"runs at {self.share:.0%} of the wanted pace: lower {self._settings}, or the load of the machine"
