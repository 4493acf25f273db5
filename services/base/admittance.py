"""The free-floating body: ``M dv/dt = w - D v`` within limits of speed and acceleration, solved exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass

from services.base.planar_wrench import Planar

REST: Planar = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SpeedLimits:
    """A convex set of velocities around rest; a base that cannot go sideways has a limit of zero there.

    Attributes:
        forwards: [m/s] along +x; ``backwards`` along -x, ``sideways`` along y.
        linear: [m/s] Euclidean norm of both.
        angular: [rad/s].
    """

    forwards: float
    backwards: float
    sideways: float
    linear: float
    angular: float

    def clip(self, velocity: Planar) -> Planar:
        """A velocity within the limits; beyond ``linear`` alone it keeps its direction."""
        # What the base cannot do at all takes no share of the norm.
        vx, vy = velocity[0], velocity[1] if self.sideways > 0.0 else 0.0
        speed = math.hypot(vx, vy)
        if speed > self.linear:
            vx, vy = vx * (self.linear / speed), vy * (self.linear / speed)
        return (
            min(max(vx, -self.backwards), self.forwards),
            min(max(vy, -self.sideways), self.sideways),
            min(max(velocity[2], -self.angular), self.angular),
        )


@dataclass(frozen=True)
class Admittance:
    """The body and its largest accelerations.

    Attributes:
        mass: M [kg]; ``inertia`` [kg m2] about z.
        damping_linear: D [N s/m]; ``damping_angular`` [Nm s/rad].
        acceleration_linear: [m/s2] Euclidean norm; ``acceleration_angular`` [rad/s2].
    """

    mass: float
    inertia: float
    damping_linear: float
    damping_angular: float
    acceleration_linear: float
    acceleration_angular: float

    def follow(self, velocity: Planar, wrench: Planar, limits: SpeedLimits, dt: float) -> Planar:
        """Velocity [m/s, m/s, rad/s] after ``dt`` [s] of a constant wrench [N, N, Nm].

        The limits of speed act on the velocity D^-1 w to which the wrench drives the body: they are convex and it
        moves in a straight line towards a point within them, so it never leaves them, at any rate.
        """
        fx, fy, tz = wrench
        driven = limits.clip((fx / self.damping_linear, fy / self.damping_linear, tz / self.damping_angular))
        vx, vy = _approach(velocity[:2], driven[:2], self.damping_linear / self.mass, self.acceleration_linear, dt)
        (wz,) = _approach(velocity[2:], driven[2:], self.damping_angular / self.inertia, self.acceleration_angular, dt)
        return vx, vy, wz

    def brake(self, velocity: Planar, dt: float) -> Planar:
        """Velocity [m/s, m/s, rad/s] after ``dt`` [s] of slowing down as hard as is allowed, in the same direction."""
        vx, vy = _slower(velocity[:2], self.acceleration_linear * dt)
        (wz,) = _slower(velocity[2:], self.acceleration_angular * dt)
        return vx, vy, wz


def _approach(
    velocity: tuple[float, ...], driven: tuple[float, ...], rate: float, acceleration: float, dt: float
) -> tuple[float, ...]:
    """Solution after ``dt`` of ``dv/dt = rate (driven - v)``, shortened to ``acceleration``.

    The difference keeps its direction. Its length falls by ``acceleration`` a second down to ``acceleration / rate``
    and exponentially from there on.
    """
    difference = [there - here for there, here in zip(driven, velocity, strict=True)]
    distance = math.hypot(*difference)
    if distance == 0.0:
        return velocity
    full = min(dt, max(0.0, distance - acceleration / rate) / acceleration)
    covered = acceleration * full
    covered -= (distance - covered) * math.expm1(-rate * (dt - full))
    share = min(1.0, covered / distance)
    return tuple(here + share * part for here, part in zip(velocity, difference, strict=True))


def _slower(velocity: tuple[float, ...], by: float) -> tuple[float, ...]:
    speed = math.hypot(*velocity)
    if speed <= by:
        return (0.0,) * len(velocity)
    return tuple(part * (1.0 - by / speed) for part in velocity)
