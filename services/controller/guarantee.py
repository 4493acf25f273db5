"""What the certified law guarantees under a configuration, and which number limits it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from services.controller.bounds.caps import AXES, Caps
from services.controller.bounds.stiffness_bound import TURN_QUANTUM, StiffnessBound
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

MOVING_FACTOR = 3.0
"""Peak of the excess in a moving environment over what Kbar lets the wrench grow by until the tool can have followed:
nearly the largest of the benchmark's steady pulls (docs/guarantee.md, "A moving environment"). Measured, not proven."""
_ROUNDS = 20
_PARALLEL = np.eye(3)


@dataclass(frozen=True)
class Certificate:
    """What holds along one axis while the tool approaches from free space, tool and base axes parallel.

    Attributes:
        axis: its name.
        speed: certified approach speed [m/s, rad/s].
        limited_by: the number that limits it.
        excess: expected worst excess [N, Nm] of the wrench's axis over its limit while the environment moves.
    """

    axis: str
    speed: float
    limited_by: str
    excess: float


def certificates(
    parameters: ControllerParameters, limit: Array, error_bound: Array, environment_speed: float = 0.1
) -> list[Certificate]:
    """The certificate of each axis.

    Args:
        parameters: of the controller.
        limit: wbar (6,) [N, Nm].
        error_bound: eps (6,) [N, Nm].
        environment_speed: [m/s], in whatever direction.

    Raises:
        ValueError: if the limits cannot be kept with such errors; the text says why.
    """
    caps = Caps(parameters.reserve, parameters.yield_start)
    inertia = np.zeros(6)
    inertia[:3] = parameters.payload_mass * np.array(parameters.max_acceleration[:3])
    caps.update(limit, error_bound + inertia)
    if caps.refusal is not None:
        raise ValueError(caps.refusal)
    # After D the tool answers, and speeds up to the environment's speed.
    lasts = response(parameters) + environment_speed / (2.0 * min(parameters.max_acceleration[:3]))
    rest = _bound(parameters, limit, 0.0)
    found = []
    for axis in range(6):
        speed, reason = _approach(parameters, limit, caps, axis)
        growth = environment_speed * math.hypot(*rest.rows[axis][:3])
        excess = MOVING_FACTOR * growth * lasts
        found.append(Certificate(AXES[axis], speed, reason, excess))
    return found


def response(parameters: ControllerParameters) -> float:
    """D [s], from a sample until the answer to it has acted; the strict form yields a period later."""
    return parameters.horizon + (0.0 if parameters.yield_start < 1.0 else parameters.period)


def stiffness(parameters: ControllerParameters, limit: Array, rotation: Array) -> Array:
    """Kbar (6, 6) in base axes for a tool with the rotation (3, 3) in base."""
    return _bound(parameters, limit, 0.0, rotation).matrix


def _bound(
    parameters: ControllerParameters, limit: Array, turn: float, rotation: Array = _PARALLEL
) -> StiffnessBound:
    bound = StiffnessBound(parameters.contact_zones)
    # A bound may be kept until it is wider than needed by twice the quantum; this is the widest.
    widest = turn + parameters.max_angular * parameters.period + TURN_QUANTUM
    bound.update(rotation, widest, limit[:3].tolist())
    return bound


def _approach(parameters: ControllerParameters, limit: Array, caps: Caps, axis: int) -> tuple[float, str]:
    """``min_j A_j / (Kbar_ji (T + d + tau))``, the own axis less its reserve; iterated, since turning widens Kbar."""
    linear = axis < 3
    fastest = (parameters.max_linear, "max_linear") if linear else (parameters.max_angular, "max_angular")
    slowest = (0.0, "")
    for _ in range(_ROUNDS):
        bound = _bound(parameters, limit, 0.0 if linear else slowest[0] * (parameters.delay + parameters.lag))
        allowed = [
            (caps.levels[0][j] / (bound.rows[j][axis] * parameters.horizon), f"limit {AXES[j]}")
            for j in range(6)
        ]
        own = caps.levels[2][axis] / (bound.rows[axis][axis] * parameters.horizon)
        slowest = min(fastest, *allowed, (own, f"limit {AXES[axis]} less the reserve"))
    return float(slowest[0]), slowest[1]
