"""What the base's motion does to the tool and to the wrench, and what speeds follow from it: the table of docs/base.md.

``python -m benchmarks.base_motion [--excess SHARE]``
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from services.base.parameters import BaseParameters
from services.controller.bounds.stiffness_bound import StiffnessBound
from services.controller.parameters import ControllerParameters
from services.task.parameters import TaskParameters
from shared.spatial import Array

COMMAND = "python -m benchmarks.base_motion"
TOOL = (0.5, -0.3, 1.0)
"""Position [m] of the tool in base: about where it carries."""
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


def declared(turn: float = 0.0) -> Array:
    """Kbar (6, 6) of the controller's default contact with the limits of the carry, tool axes along base axes.

    It holds while the base turns by ``turn`` [rad] and a little more.
    """
    bound = StiffnessBound(ControllerParameters().contact_zones)
    bound.update(np.eye(3), turn, list(TaskParameters().force_limit))
    return bound.matrix.copy()


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table for the default parameters, and the two speeds for an excess."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--excess", type=float, default=1.0, help="wanted peak beyond the limit, share of it")
    excess = parser.parse_args(arguments).excess
    if not 0.0 < excess < float("inf"):
        parser.error(f"--excess is {excess:g}, wanted a positive number: 1 is a peak of twice the limit")
    base, task, response = BaseParameters(), TaskParameters(), ControllerParameters().horizon
    limit = np.array((*task.force_limit, *task.torque_limit))
    per_speed, per_turn = wrench_rates(declared(), TOOL)
    _, per_turn_meanwhile = wrench_rates(declared(base.max_angular * response), TOOL)
    rows = (
        ("a [N/m, Nm/m]", per_speed, ".0f"),
        ("c [N/rad, Nm/rad]", per_turn, ".0f"),
        (f"rise at {base.max_linear:g} m/s, in limits", response * base.max_linear * per_speed / limit, ".1f"),
        (
            f"rise at {base.max_angular:g} rad/s, in limits",
            response * base.max_angular * per_turn_meanwhile / limit,
            ".1f",
        ),
        (f"v of this axis alone for e = {excess:g} [m/s]", excess * limit / (PEAK * response * per_speed), ".2g"),
    )
    print("| | fx | fy | fz | about x | about y | about z |\n|---|---|---|---|---|---|---|")
    for name, values, form in rows:
        print(f"| {name} | {' | '.join(format(value, form) for value in values.tolist())} |")
    speed, turning = speed_limits(declared(), TOOL, limit, excess, response)
    print(f"\nFor an excess of {excess:g} limits: {speed:.2g} m/s, or {turning:.2g} rad/s.")


if __name__ == "__main__":
    main()
