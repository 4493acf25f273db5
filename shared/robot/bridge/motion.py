"""Motion of joints that come to rest by themselves: the short trajectories that their controllers are told.

While joints move, their controllers are told, again and again, a trajectory that starts where the one before has led by
now, at q with q'. With v the speeds to go at, r the ramp, h the horizon and t the time that braking takes, it says

    at r        q + r (q' + v) / 2                          at v
    at h        q + r (q' + v) / 2 + (h - r) v              at v
    at h + t    q + r (q' + v) / 2 + (h - r + t / 2) v      at rest

and controllers put cubics in between, which are these parabolas exactly. So a bridge that dies leaves joints that are
at rest h + t later, on the path that they were on. To come to rest at once there is only the last point, t from now.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shared.robot.far_side import TrajectoryPoint
from shared.spatial import Array

RAMP = 0.03
"""[s] in which speeds change: longer than trajectories are late by, or their lateness would be felt."""
HORIZON = 0.06
"""[s] of motion before it brakes: trajectories may come later than each other by so much."""
BRAKING = 0.15
"""[s] that braking takes at most: no joint goes faster than it can brake in this time."""
REST_WITHIN = HORIZON + BRAKING
"""[s] after the last trajectory in which the joints are at rest."""
APPROACH_RATE = 1.0 / REST_WITHIN
"""[1/s] of speed per distance to a limit, with which joints come to rest before it."""
SLACK = 0.03
"""[rad, m] Farthest that a set-point is from a joint at rest, such as one that is held."""
LAG = 0.15  # [s] of a moving joint behind its set-point that is no sign of being held
_SHORTEST = 0.02  # [s] of braking: a controller need not follow less
_AT_REST = 1e-9  # [rad/s, m/s]


@dataclass(frozen=True)
class _Leg:
    """Joints that go from one speed to another at constant acceleration: all arrays (n,)."""

    begin: float
    length: float
    position: Array
    before: Array
    after: Array

    def at(self, time: float) -> tuple[Array, Array]:
        """Positions and speeds at a time [s] since the trajectory began, or at the leg's end if that is earlier."""
        passed = min(max(time - self.begin, 0.0), self.length)
        change = (self.after - self.before) * (passed / self.length)
        return self.position + passed * (self.before + 0.5 * change), self.before + change

    def then(self, length: float, speed: Array) -> _Leg:
        """The leg that follows."""
        return _Leg(self.begin + self.length, length, self.at(np.inf)[0], self.after, speed)


class JointMotion:
    """Set-points of n joints, whose speeds change no faster than they can.

    Whatever is too fast a change is shortened as a whole, so that the tool stays on its path.

    Attributes:
        speed: largest speeds (n,) that the joints may have [rad/s, m/s].

    Args:
        lower, upper: position limits (n,) [rad, m].
        speed: as the description or the profile has it (n,) [rad/s, m/s].
        acceleration: that each joint can always reach (n,) [rad/s2, m/s2].
    """

    def __init__(self, lower: Array, upper: Array, speed: Array, acceleration: Array) -> None:
        self._lower, self._upper = lower, upper
        self.speed: Array = np.minimum(speed, BRAKING * acceleration)
        self._acceleration = acceleration
        self.start(np.clip(np.zeros(len(lower)), lower, upper))

    def start(self, position: Array) -> None:
        """Begin anew at positions (n,) [rad, m], at rest."""
        standing = np.zeros(len(position))
        self._legs: tuple[_Leg, ...] = (_Leg(0.0, _SHORTEST, position.copy(), standing, standing),)

    def at(self, age: float) -> tuple[Array, Array]:
        """Set-points (n,) [rad, m] and their speeds (n,), so long [s] after the last trajectory was told."""
        leg = next((leg for leg in self._legs if age < leg.begin + leg.length), self._legs[-1])
        return leg.at(age)

    def moving(self, age: float) -> bool:
        """Whether the set-points move, so long [s] after the last trajectory was told."""
        return bool((np.abs(self.at(age)[1]) > _AT_REST).any())

    @property
    def ends(self) -> bool:
        """Whether the last trajectory says nothing but to come to rest."""
        return len(self._legs) == 1

    def tell(self, position: Array, velocity: Array, wanted: Array) -> list[TrajectoryPoint]:
        """The trajectory to tell now.

        Args:
            position: set-points (n,) [rad, m] of now, as ``at`` has them or nearer to where the joints are.
            velocity: their speeds (n,) [rad/s, m/s].
            wanted: speeds (n,) to go at [rad/s, m/s]; all zero to come to rest at once.
        """
        if not wanted.any():
            braking = self._braking(velocity)
            self._legs = (_Leg(0.0, braking, position, velocity, np.zeros(len(wanted))),)
        else:
            speed = self._reached(position, velocity, wanted)
            ramp = _Leg(0.0, RAMP, position, velocity, speed)
            cruise = ramp.then(HORIZON - RAMP, speed)
            self._legs = (ramp, cruise, cruise.then(self._braking(speed), np.zeros(len(wanted))))
        return [TrajectoryPoint(leg.begin + leg.length, *leg.at(np.inf)) for leg in self._legs]

    def near(self, position: Array, velocity: Array, measured: Array) -> Array:
        """Set-points (n,) within reach of where the joints are (n,) [rad, m]."""
        reach = SLACK + LAG * np.abs(velocity)
        return np.minimum(np.maximum(position, measured - reach), measured + reach)

    def _reached(self, position: Array, velocity: Array, wanted: Array) -> Array:
        """Speeds (n,) at the end of the ramp."""
        change = wanted - velocity
        needed = float((np.abs(change) / self._acceleration).max())
        speed = velocity + change * min(1.0, RAMP / needed) if needed > 0.0 else velocity
        # A joint that comes close to its limit brakes by itself, whatever that does to the path.
        lowest = np.minimum(np.maximum(APPROACH_RATE * (self._lower - position), -self.speed), 0.0)
        highest = np.maximum(np.minimum(APPROACH_RATE * (self._upper - position), self.speed), 0.0)
        most = RAMP * self._acceleration
        speed = np.minimum(np.maximum(speed, lowest), highest)
        return np.minimum(np.maximum(speed, velocity - most), velocity + most)

    def _braking(self, velocity: Array) -> float:
        return max(float((np.abs(velocity) / self._acceleration).max()), _SHORTEST)
