"""The mobile base: it moves exactly as its gate lets it, and carries the whole robot through the world."""

from __future__ import annotations

import math

from shared.spatial import GRAVITY

Vector = tuple[float, float, float]


class MobileBase:
    """Pose and motion of ``base`` in the world, which is ``base`` as it stood at the start.

    Written in plain floats because it is asked in every physics step.

    Args:
        slope: rise of the floor [rad] along x and y of the world.

    Attributes:
        x, y: position [m] in the world.
        yaw: [rad], in (-pi, pi].
        velocity: vx, vy [m/s], wz [rad/s] in base axes.
        down_in_world: unit vector of gravity there.
    """

    def __init__(self, slope: tuple[float, float] = (0.0, 0.0)) -> None:
        x, y = math.sin(slope[0]), math.sin(slope[1])
        self.down_in_world: Vector = (0.0 - x, 0.0 - y, -math.sqrt(1.0 - x * x - y * y))
        self.x = self.y = self.yaw = 0.0
        self.velocity: Vector = (0.0, 0.0, 0.0)
        self._acceleration: Vector = (0.0, 0.0, 0.0)
        self._cosine, self._sine = 1.0, 0.0

    @property
    def at_rest(self) -> bool:
        """Whether it neither moves nor is about to."""
        return not (any(self.velocity) or any(self._acceleration))

    def advance(self, velocity: Vector, dt: float) -> None:
        """Move with a velocity (3,) for ``dt`` [s], along the arc that it describes."""
        if velocity == self.velocity and not any(velocity):
            self._acceleration = (0.0, 0.0, 0.0)
            return
        before = self.velocity
        self._acceleration = (
            (velocity[0] - before[0]) / dt,
            (velocity[1] - before[1]) / dt,
            (velocity[2] - before[2]) / dt,
        )
        self.velocity = velocity
        vx, vy, wz = velocity
        # The chord of the arc: half the turn before it, half behind it.
        half = 0.5 * wz * dt
        length = dt * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        cosine, sine = math.cos(self.yaw + half), math.sin(self.yaw + half)
        self.x += length * (cosine * vx - sine * vy)
        self.y += length * (sine * vx + cosine * vy)
        self.yaw = math.remainder(self.yaw + wz * dt, math.tau)
        self._cosine, self._sine = math.cos(self.yaw), math.sin(self.yaw)

    @property
    def down(self) -> Vector:
        """Unit vector of gravity in base axes."""
        return self.turned_back(self.down_in_world)

    def turned(self, vector: Vector) -> Vector:
        """A vector in base axes, in world axes."""
        x, y, z = vector
        return self._cosine * x - self._sine * y, self._sine * x + self._cosine * y, z

    def turned_back(self, vector: Vector) -> Vector:
        """A vector in world axes, in base axes."""
        x, y, z = vector
        return self._cosine * x + self._sine * y, self._cosine * y - self._sine * x, z

    def point(self, position: Vector) -> Vector:
        """A position [m] in base, in the world."""
        x, y, z = self.turned(position)
        return self.x + x, self.y + y, z

    def velocity_of(self, position: Vector, velocity: Vector) -> Vector:
        """Velocity [m/s], world axes, of a point at a position [m] in base that moves relative to base, in its axes."""
        vx, vy, wz = self.velocity
        x, y, _ = position
        return self.turned((velocity[0] + vx - wz * y, velocity[1] + vy + wz * x, velocity[2]))

    def gravity(self, position: Vector, velocity: Vector) -> Vector:
        """Acceleration [m/s2] of gravity in base axes as a body feels it that the base carries along.

        Besides its weight it feels the base speed up and turn: the arm is simulated in base axes, so what its inertia
        does there has to be added to gravity.

        Args:
            position: of the body [m] in base.
            velocity: of the body [m/s] relative to base, in its axes.
        """
        ax, ay, turning = self._acceleration
        vx, vy, wz = self.velocity
        x, y, _ = position
        gx, gy, gz = self.down
        return (
            GRAVITY * gx + wz * vy - ax + turning * y + wz * wz * x + 2.0 * wz * velocity[1],
            GRAVITY * gy - wz * vx - ay - turning * x + wz * wz * y - 2.0 * wz * velocity[0],
            GRAVITY * gz,
        )
