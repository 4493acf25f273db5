"""The gate of a mobile base: like that of the tool (``shared.limits``), but what it moves cannot stop at once.

A base weighs a hundred kilograms: its velocity changes at a limited rate, upwards and downwards alike, and silence or a
stop means that it slows down along the path it is on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from shared.limits import SILENCE
from shared.messages import LONGEST_TTL
from shared.spatial import Array

_INSTANT = 1e-9
"""Less time [s] than this is none."""
ASKED = 0.01
"""Share of its limit above which an axis counts as asked for, next to others."""


@dataclass(frozen=True)
class BaseLimits:
    """What a base can do.

    Attributes:
        forwards, backwards, sideways: largest speeds [m/s]; ``sideways`` 0 = differential.
        turning: largest turning rate [rad/s].
        acceleration, angular_acceleration: [m/s2, rad/s2], of speeding up and of slowing down.
        together: share [1] of the limits that is left when several axes move at once, by their names: "xy", "xz", "yz",
            "xyz"; 1 if not named.
    """

    forwards: float
    backwards: float
    sideways: float
    turning: float
    acceleration: float
    angular_acceleration: float
    together: Mapping[str, float] = field(default_factory=dict)

    @property
    def largest(self) -> Array:
        """Largest velocity (3,) vx, vy [m/s], wz [rad/s] of each axis alone."""
        return np.array((self.forwards, self.sideways, self.turning))

    def excess(self, velocity: Array) -> float:
        """By what factor [1] a velocity (3,) that the base can go at all is too fast; at most 1 if it is not."""
        x, y, turn = velocity.tolist()
        shares = {
            "x": abs(x) / (self.forwards if x > 0.0 else self.backwards),
            "y": abs(y) / self.sideways if self.sideways else 0.0,
            "z": abs(turn) / self.turning,
        }
        asked = "".join(axis for axis, share in shares.items() if share > ASKED)
        return max(shares.values()) / self.together.get(asked, 1.0)


class BaseGate:
    """Turns the newest command into the velocity that the base executes.

    Attributes:
        clamped: number of commands that asked for more than is allowed, or for a way that the base cannot go.
        expired: number of motions that silence broke off.
        late: number of commands that arrived past their ``ttl``.
    """

    def __init__(self, limits: BaseLimits) -> None:
        self.limits = limits
        self.clamped = 0
        self.expired = 0
        self.late = 0
        self._wanted = np.zeros(3)
        self._executed = np.zeros(3)
        self._left = 0.0
        self._silent = math.inf
        self._stopped = False
        self._at_work = False

    def command(self, velocity: Array, ttl: float, age: float, valid: bool = True) -> None:
        """Take over the newest command; call it once per command.

        Args:
            velocity: vx, vy [m/s], wz [rad/s] (3,) in base axes.
            ttl: time [s] from its publication for which it may be executed.
            age: time [s] since its publication.
            valid: false if its publisher marks it as not to be trusted; then it means stop.
        """
        wanted = np.array(velocity, dtype=float)
        self._at_work = True
        self._left, self._silent = 0.0, math.inf
        self._wanted = np.zeros(3)
        if not (valid and np.isfinite(wanted).all() and math.isfinite(ttl) and math.isfinite(age)):
            return
        impossible = self.limits.sideways == 0.0 and wanted[1] != 0.0
        if impossible:
            wanted[1] = 0.0
        excess = self.limits.excess(wanted)
        if impossible or excess > 1.0 + 1e-9 or ttl > LONGEST_TTL:
            self.clamped += 1
        left = min(ttl, LONGEST_TTL) - max(age, 0.0)
        if left <= _INSTANT:
            self.late += 1
            return
        self._left = left
        # Shortened as a whole: the base stays on the path that was asked for.
        self._wanted = wanted / max(excess, 1.0)

    def stop(self, engaged: bool) -> None:
        """Engage or release the stop; it stays engaged until released."""
        self._stopped = engaged

    def advance(self, dt: float) -> Array:
        """Velocity (3,) vx, vy [m/s], wz [rad/s] to execute during the next ``dt`` [s]."""
        if not self._at_work:
            return self._executed
        if self._left <= _INSTANT:
            if self._silent == math.inf and self._wanted.any():
                self._silent = 0.0
            self._wanted = np.zeros(3)
        self._left -= dt
        if self._silent < SILENCE:
            self._silent += dt
            self.expired += self._silent >= SILENCE
        wanted = np.zeros(3) if self._stopped else self._wanted
        change = wanted - self._executed
        x, y, turn = change.tolist()
        needed = max(
            math.hypot(x, y) / self.limits.acceleration, abs(turn) / self.limits.angular_acceleration
        )
        self._executed = self._executed + change * (dt / needed) if needed > dt else wanted
        # Most of the time a base stands still, and this is asked in every physics step.
        waiting = self._left > _INSTANT or self._silent < SILENCE
        self._at_work = waiting or bool(self._executed.any())
        return self._executed
