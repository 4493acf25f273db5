"""The gate: the last hop on the robot's side, in front of the simulation and of every hardware bridge alike.

A gate executes a command only while it is fresh, never faster than allowed, and speeds up no more than allowed; silence
means stop, and a stop stays until it is released. The gate knows nothing of the controller and trusts nobody.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from shared.messages import LONGEST_TTL
from shared.spatial import Array

INSTANT = 1e-9  # [s] of time that are none: rounding errors of durations stay below it
SILENCE = 0.1  # [s] past its ``ttl`` after which a moving command counts as the last one before a silence


@dataclass(frozen=True)
class GateLimits:
    """Limits of a six-dimensional gate.

    Attributes:
        max_linear: Euclidean norm of the linear part [m/s].
        max_angular: Euclidean norm of the angular part [rad/s].
        max_linear_acceleration: speeding-up of the linear part [m/s2]; slowing down is free.
        max_angular_acceleration: speeding-up of the angular part [rad/s2].
    """

    max_linear: float
    max_angular: float
    max_linear_acceleration: float
    max_angular_acceleration: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"gate limit {name} is {value}, wanted a positive finite number")


class Gate:
    """Turns the newest command into the twist that is executed.

    Whatever has to be shortened is shortened as a whole vector: for the certified law every shortened twist is
    certified too, a bent one need not be.

    Attributes:
        clamped: number of commands that asked for more than is allowed.
        expired: number of motions that silence broke off. Commands that come more slowly than their ``ttl`` end are
            one motion.
        late: number of commands that arrived past their ``ttl``.
        held: number of times that it broke off a motion for want of a fresh and valid command, however shortly.
    """

    def __init__(self, limits: GateLimits) -> None:
        self.limits = limits
        self._wanted = np.zeros(6)
        self._moving = False
        self._executed = np.zeros(6)
        self._share = 0.0
        self._left = 0.0
        self._stopped = ""
        self.clamped = 0
        self.expired = 0
        self.late = 0
        self.held = 0
        self._broken_off = False
        self._ran_out = False

    def command(self, linear: Array, angular: Array, ttl: float, age: float, valid: bool = True) -> None:
        """Take over the newest command; call it once per command.

        Args:
            linear: linear velocity (3,) [m/s].
            angular: angular velocity (3,) [rad/s].
            ttl: time [s] from its publication for which it may be executed.
            age: time [s] since its publication.
            valid: false if its publisher marks it as not to be trusted; then it means stop.
        """
        wanted = np.concatenate((linear, angular))
        self._broken_off = self._ran_out = False
        if not (valid and np.isfinite(wanted).all() and math.isfinite(ttl) and math.isfinite(age)):
            self._want(np.zeros(6))
            self._left = 0.0
            return
        speed_linear, speed_angular = _norms(wanted)
        excess = max(speed_linear / self.limits.max_linear, speed_angular / self.limits.max_angular)
        # One rounding error of a command exactly at the limit is no excess.
        if excess > 1.0 + 1e-9 or ttl > LONGEST_TTL:
            self.clamped += 1
        self._want(wanted / max(excess, 1.0))
        self._left = min(ttl, LONGEST_TTL) - max(age, 0.0)
        if self._left <= INSTANT:
            self.late += 1
            self._want(np.zeros(6))

    def _want(self, twist: Array) -> None:
        self._wanted = twist
        self._moving = bool(twist.any())
        self._share = 0.0

    def stop(self, engaged: bool, reason: str) -> None:
        """Engage or release the stop; it stays engaged until released."""
        self._stopped = (reason or "no reason given") if engaged else ""

    def advance(self, dt: float) -> Array:
        """Twist (6,) [m/s, rad/s] to execute during the next ``dt`` [s].

        Raises:
            ValueError: if ``dt`` is no duration.
        """
        if not 0.0 <= dt < math.inf:
            raise ValueError(f"dt is {dt}, wanted a finite duration in seconds")
        if self._stopped or self._left <= INSTANT:
            self._broken_off = not self._stopped and (self._moving or self._broken_off)
            if not self._stopped and self._executed.any():
                self._run_out()
            self._want(np.zeros(6))
            self._executed = np.zeros(6)
        elif self._moving:
            # Of the last interval only the part that the ttl leaves: no command travels further than speed times ttl.
            left = self._left / dt if dt > self._left else 1.0
            if dt - self._left > INSTANT:
                self._run_out()
            # What is executed in full stays so: a process steps several times per command.
            if self._share < 1.0 or left < 1.0:
                self._share = min(self._reachable(dt), left)
                self._executed = self._wanted * self._share
        else:
            self._executed = np.zeros(6)
        self._left -= dt
        if self._broken_off and -self._left >= SILENCE:
            self.expired += 1
            self._broken_off = False
        return self._executed.copy()

    def _run_out(self) -> None:
        """Count a motion that is broken off, once, although its last interval may be cut before it ends."""
        self.held += not self._ran_out
        self._ran_out = True

    def _reachable(self, dt: float) -> float:
        """Share [1] of the wanted twist that can be reached now: what is executed along it, plus the acceleration."""
        share = 1.0
        for part, acceleration in (
            (slice(0, 3), self.limits.max_linear_acceleration),
            (slice(3, 6), self.limits.max_angular_acceleration),
        ):
            wanted = self._wanted[part]
            speed = math.sqrt(float(wanted @ wanted))
            # In squared form a denormal speed would divide by zero.
            if speed > 1e-12:
                present = max(0.0, float(self._executed[part] @ wanted) / speed)
                share = min(share, (present + acceleration * dt) / speed)
        return share

    @property
    def mode(self) -> str:
        """State of the gate: ready (executes a command), stopped (a stop is engaged), holding (neither)."""
        if self._stopped:
            return "stopped"
        return "ready" if self._left > 0.0 else "holding"

    @property
    def reason(self) -> str:
        """Why the robot does not execute commands; empty if it does."""
        if self._stopped:
            return f"stop engaged: {self._stopped}. Release it with `tandem resume`"
        return "" if self._left > 0.0 else "no fresh command"


def _norms(twist: Array) -> tuple[float, float]:
    """Euclidean norms of the linear and the angular part; infinite where the square overflows."""
    return math.hypot(*twist[:3].tolist()), math.hypot(*twist[3:].tolist())
