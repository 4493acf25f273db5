"""Onboard differential inverse kinematics: a wanted tool twist becomes joint velocities.

Each call solves in the joint velocities q' (n) and the executed share s of the twist V

    minimise    a |q'|_W^2 / 2 + b |q' - q'_p|_W^2 / 2 - c |V|^2 s
    subject to  J q' = s V                      the direction is never distorted, only the speed reduced
                0 <= s <= 1
                l <= q' <= u                    speed limits, and braking before position limits

in closed form where no bound is active, otherwise with PIQP. q'_p draws the redundant joints towards the reference
posture. Near a singularity the speeds that a full twist needs grow without bound; c bounds their price, so s falls
smoothly there. A zero twist gives exactly zero velocities.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import piqp

from shared.spatial import Array

APPROACH_RATE = 10.0  # [1/s] of speed allowed per distance left to the limit
POSTURE_RATE = 1.0  # [1/s] at which the redundancy returns to the reference posture
POSTURE_SPEED = 0.3  # [rad/s, m/s] wanted at most for that return
MOVING = 0.02  # [m/s] of the twist below which the posture's pull fades out with it
ANGULAR_LENGTH = 0.3  # [m] that makes an angular velocity comparable to a linear one
EFFORT_WEIGHT, POSTURE_WEIGHT = 0.1, 1.0  # [1] a and b
PRICE = 1000.0  # [rad2/m2] c: square of the joint speed per tool speed above which the twist is slowed down

_REGULARISATION = 1e-12 * np.eye(6)


@dataclass(frozen=True)
class Solution:
    """Joint velocities (n,) [rad/s, m/s], the executed share of the twist [0, 1], and what limits it (or "")."""

    velocity: Array
    share: float
    limited_by: str


class DifferentialIK:
    """The problem above for one arm.

    Args:
        lower, upper, speed: position limits [rad, m] and speed limits [rad/s, m/s] of the joints, (n,) each.
        margin: distance [rad, m] from a position limit at which a joint stands still, (n,).
        names: the joints' names, for reports.
        weight: W, relative cost (n,) of the joints' speeds.
        approach_rate: [1/s] of speed allowed per distance left to a position limit.
    """

    def __init__(
        self,
        lower: Array,
        upper: Array,
        speed: Array,
        margin: Array,
        names: tuple[str, ...],
        weight: Array,
        approach_rate: float = APPROACH_RATE,
    ) -> None:
        self._lower = lower + margin
        self._upper = upper - margin
        self._speed = speed
        self._names = names
        self._weight = weight
        self._approach_rate = approach_rate
        n = len(names)
        self._n = n
        self._ease = 1.0 / ((EFFORT_WEIGHT + POSTURE_WEIGHT) * weight)
        self._hessian = np.zeros((n + 1, n + 1))
        self._hessian[range(n), range(n)] = (EFFORT_WEIGHT + POSTURE_WEIGHT) * weight
        # PIQP wants a strictly convex problem; next to c this curvature of s is nothing.
        self._hessian[n, n] = 1e-9
        self._equations = np.zeros((6, n + 1))
        self._solver = _solver()
        self._ready = False

    def bounds(self, position: Array) -> tuple[Array, Array]:
        """Smallest and largest joint velocities (n,) allowed at a position; zero is always between them."""
        lowest = np.minimum(np.maximum(self._approach_rate * (self._lower - position), -self._speed), 0.0)
        highest = np.maximum(np.minimum(self._approach_rate * (self._upper - position), self._speed), 0.0)
        return lowest, highest

    def solve(self, position: Array, jacobian: Array, twist: Array, reference: Array, lead: Array) -> Solution:
        """Joint velocities for a twist.

        Args:
            position: joint positions (n,).
            jacobian: (6, n), base axes.
            twist: wanted tool twist (6,) in base axes.
            reference: posture (n,) that the redundancy returns to.
            lead: velocity (n,) of that posture.

        If any of them is not finite, nothing moves, and the next call is as good as ever.
        """
        x, y, z, about_x, about_y, about_z = twist.tolist()
        size = math.hypot(x, y, z, ANGULAR_LENGTH * about_x, ANGULAR_LENGTH * about_y, ANGULAR_LENGTH * about_z)
        if size == 0.0:
            return Solution(np.zeros(self._n), 1.0, "")
        lowest, highest = self.bounds(position)
        wanted = POSTURE_RATE * (reference - position)
        wanted = np.minimum(np.maximum(wanted, -POSTURE_SPEED), POSTURE_SPEED) + lead
        wanted *= min(1.0, size / MOVING)
        # In units of the twist's size the problem is equally well scaled for a creep and for full speed.
        direction = twist / size
        velocity, price = self._unbounded(jacobian, direction, wanted / size)
        velocity *= size
        if price <= PRICE and (velocity >= lowest).all() and (velocity <= highest).all():
            return Solution(velocity, 1.0, "")
        return self._bounded(jacobian, direction, wanted / size, lowest, highest, size)

    def _unbounded(self, jacobian: Array, direction: Array, wanted: Array) -> tuple[Array, float]:
        """The optimum at s = 1 without bounds in closed form, and what the last bit of s costs there.

        If both keep their bounds this is the solution of the whole problem, at a fifth of a solver's time.
        """
        drift = POSTURE_WEIGHT / (EFFORT_WEIGHT + POSTURE_WEIGHT) * wanted
        # For matrices as small as these, dot takes half the time of @.
        towards = (jacobian * self._ease).T
        gram = jacobian.dot(towards) + _REGULARISATION
        multiplier = np.linalg.solve(gram, direction - jacobian.dot(drift))
        return drift + towards.dot(multiplier), float(multiplier.dot(direction))

    def _bounded(
        self, jacobian: Array, direction: Array, wanted: Array, lowest: Array, highest: Array, size: float
    ) -> Solution:
        n = self._n
        gradient = np.append(-POSTURE_WEIGHT * self._weight * wanted, -PRICE)
        self._equations[:, :n] = jacobian
        self._equations[:, n] = -direction
        below, above = np.append(lowest / size, 0.0), np.append(highest / size, 1.0)
        # What is not finite never gets past the comparisons that lead round this method, and it must not get into the
        # solver: that keeps it for ever.
        if not all(np.isfinite(part).all() for part in (gradient, self._equations, below, above)):
            return Solution(np.zeros(n), 0.0, "the inverse kinematics was given a number that is not finite")
        if self._ready:
            self._solver.update(P=self._hessian, c=gradient, A=self._equations, x_l=below, x_u=above)
        else:
            self._solver.setup(P=self._hessian, c=gradient, A=self._equations, b=np.zeros(6), x_l=below, x_u=above)
            self._ready = True
        status = self._solver.solve()
        result = np.array(self._solver.result.x)
        if status != piqp.PIQP_SOLVED or not np.all(np.isfinite(result)):
            self._solver, self._ready = _solver(), False
            return Solution(np.zeros(n), 0.0, self._reason(np.zeros(n), lowest, highest))
        share = min(1.0, max(0.0, float(result[n])))
        velocity = np.minimum(np.maximum(result[:n] * size, lowest), highest)
        reason = "" if share > 0.999 else self._reason(velocity, lowest, highest)
        return Solution(velocity, share, reason)

    def _reason(self, velocity: Array, lowest: Array, highest: Array) -> str:
        close = 1e-3 * self._speed
        for i, name in enumerate(self._names):
            if velocity[i] >= highest[i] - close[i] and highest[i] < self._speed[i]:
                return f"{name} is at its upper limit"
            if velocity[i] <= lowest[i] + close[i] and lowest[i] > -self._speed[i]:
                return f"{name} is at its lower limit"
            if abs(velocity[i]) >= self._speed[i] - close[i]:
                return f"{name} is at its speed limit"
        return "the arm is close to a singularity"


def _solver() -> piqp.DenseSolver:
    solver = piqp.DenseSolver()
    solver.settings.verbose = False
    solver.settings.eps_abs = 1e-9
    solver.settings.eps_rel = 1e-9
    return solver
