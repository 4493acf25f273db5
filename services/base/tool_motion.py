"""What the base's motion does to the tool and to the wrench: it counts in the guarantee (docs/base.md)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from shared.spatial import Array

PEAK = 3.0
"""Peak of the wrench's excess over its rise within the response time, while the arm yields: measured, nearly the
largest of all contacts in six axes (docs/guarantee.md, "A moving environment")."""


def tool_twist(velocity: ArrayLike, position: ArrayLike) -> Array:
    """Twist (6,) [m/s, rad/s] of a tool that rests in base, relative to the ground, in base axes.

    Args:
        velocity: (3,) of the base: vx, vy [m/s], wz [rad/s].
        position: (3,) [m] of the tool in base.
    """
    vx, vy, wz = np.asarray(velocity, dtype=float).tolist()
    x, y, _ = np.asarray(position, dtype=float).tolist()
    return np.array((vx - wz * y, vy + wz * x, 0.0, 0.0, 0.0, wz))


def wrench_rates(stiffness: Array, position: ArrayLike) -> tuple[Array, Array]:
    """Largest rates of the wrench: (6,) [N/m, Nm/m] per speed in any direction, (6,) [N/rad, Nm/rad] per turning rate.

    Args:
        stiffness: Kbar (6, 6), bound on |dw_i/dx_j| in base axes [N/m, N/rad, Nm/m, Nm/rad].
        position: (3,) [m] of the tool in base.
    """
    x, y, _ = np.abs(np.asarray(position, dtype=float)).tolist()
    along_x, along_y, about_z = stiffness[:, 0], stiffness[:, 1], stiffness[:, 5]
    return np.hypot(along_x, along_y), y * along_x + x * along_y + about_z


def speed_limits(
    stiffness: Array, position: ArrayLike, limit: ArrayLike, excess: float, response: float
) -> tuple[float, float]:
    """Speed [m/s] and turning rate [rad/s] of the base, each alone, for which the wrench exceeds no limit by more.

    Together they keep it while ``speed / first + turning rate / second <= 1``.

    Args:
        stiffness: Kbar (6, 6) in base axes, as in ``wrench_rates``.
        position: (3,) [m] of the tool in base.
        limit: wbar (6,) [N, Nm].
        excess: wanted peak beyond the limit, share of each limit.
        response: T + d + tau [s], from a sample until the arm's answer to it has acted.
    """
    allowed = excess * np.asarray(limit, dtype=float) / (PEAK * response)
    speed, turning = (float(1.0 / np.max(rates / allowed)) for rates in wrench_rates(stiffness, position))
    return speed, turning
