"""The gate of a mobile base: like that of the tool (``shared.robot.gate``), but a base cannot stop at once.

A base weighs a hundred kilograms: its velocity changes at a limited rate, upwards and downwards alike, and silence or a
stop means that it slows down along the path it is on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from shared.messages import LONGEST_TTL
from shared.robot.gate import INSTANT, SILENCE
from shared.spatial import Array

ASKED = 0.01  # [1] share of its limit above which an axis counts as asked for, next to others
_WHOLE = 1.0 + 1e-9  # [1] share of a limit: one rounding error of a command exactly at it is no excess


class _Way(NamedTuple):
    """How fast the base is to go along an axis, and how fast it can that way [m/s, rad/s]."""

    axis: str
    name: str
    limit: float
    speed: float
    unit: str

    @property
    def closed(self) -> bool:
        """Whether the base cannot go that way at all."""
        return self.limit == 0.0 and self.speed != 0.0

    @property
    def share(self) -> float:
        """Share [1] of the limit that the speed is."""
        return abs(self.speed) / self.limit if self.limit else 0.0


@dataclass(frozen=True)
class BaseLimits:
    """Abilities of a base.

    Attributes:
        forwards, backwards, sideways: largest speeds [m/s]; 0 = not that way at all, as a differential base sideways.
        turning: largest turning rate [rad/s]; 0 = not at all.
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
        """Largest velocity (3,) of each axis alone: vx, vy [m/s], wz [rad/s]."""
        return np.array((self.forwards, self.sideways, self.turning))

    def within(self, velocity: Array) -> tuple[Array, str]:
        """The velocity (3,) that the base can go, and the limit that has shortened it, in words; empty if none has.

        The velocity is shortened as a whole, so that the base stays on the path that was asked for; a way that it
        cannot go at all is left out.
        """
        ways = self._ways(*velocity.tolist())
        asked = [way for way in ways if way.share > ASKED]
        together = self.together.get("".join(way.axis for way in asked), 1.0)
        excess = max(way.share for way in ways) / together
        over = [f"{way.name} over {way.limit:g} {way.unit}" for way in ways if way.closed or way.share > _WHOLE]
        if excess > _WHOLE and together < 1.0:
            over = [f"{' and '.join(way.name for way in asked)} together over {together:g} of their limits"]
        able = np.array([0.0 if way.closed else way.speed for way in ways])
        return able / max(excess, 1.0), " and ".join(over)

    def _ways(self, x: float, y: float, turn: float) -> tuple[_Way, _Way, _Way]:
        ahead = ("forwards", self.forwards) if x > 0.0 else ("backwards", self.backwards)
        return (
            _Way("x", *ahead, x, "m/s"),
            _Way("y", "sideways", self.sideways, y, "m/s"),
            _Way("z", "turning", self.turning, turn, "rad/s"),
        )


class BaseGate:
    """Turns the newest command into the velocity that the base executes.

    Attributes:
        clamped: number of commands that asked for more than is allowed, or for a way that the base cannot go.
        clamped_by: the limit that the last of them was over, in words.
        expired: number of motions that silence broke off.
        late: number of commands that arrived past their ``ttl``.
    """

    def __init__(self, limits: BaseLimits) -> None:
        self.limits = limits
        self.clamped = 0
        self.clamped_by = ""
        self.expired = 0
        self.late = 0
        self._wanted = np.zeros(3)
        self._executed = np.zeros(3)
        self._left = 0.0
        self._silent = math.inf
        self._stopped = False
        self._at_work = False

    def rest(self) -> None:
        """Go on from rest: what was executed has ended without the gate."""
        self._executed = np.zeros(3)

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
        able, over = self.limits.within(wanted)
        if over or ttl > LONGEST_TTL:
            self.clamped += 1
            self.clamped_by = over or f"ttl over {LONGEST_TTL:g} s"
        left = min(ttl, LONGEST_TTL) - max(age, 0.0)
        if left <= INSTANT:
            self.late += 1
            return
        self._left = left
        self._wanted = able

    def stop(self, engaged: bool) -> None:
        """Engage or release the stop; it stays engaged until released."""
        self._stopped = engaged

    def advance(self, dt: float) -> Array:
        """Velocity (3,) vx, vy [m/s], wz [rad/s] to execute during the next ``dt`` [s]."""
        if not self._at_work:
            return self._executed
        if self._left <= INSTANT:
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
        needed = max(math.hypot(x, y) / self.limits.acceleration, abs(turn) / self.limits.angular_acceleration)
        self._executed = self._executed + change * (dt / needed) if needed > dt else wanted
        # Most of the time a base stands still, and this is asked in every physics step.
        waiting = self._left > INSTANT or self._silent < SILENCE
        self._at_work = waiting or bool(self._executed.any())
        return self._executed
