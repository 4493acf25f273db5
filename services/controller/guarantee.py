"""What the certified law guarantees under a configuration, and which number limits it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from services.controller.bounds.caps import AXES, Caps
from services.controller.bounds.stiffness_bound import TURN_QUANTUM, StiffnessBound
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

MOVING_FACTOR = 3.0
"""Peak of the excess in a moving environment over what Kbar lets the wrench grow by until the tool can have followed:
nearly the largest of the benchmark's steady pulls (docs/guarantee.md, "A moving environment"). Measured, not proven."""
_ROUNDS = 20
"""Iterations of a speed whose turning widens the bound that it follows from; it settles after a few."""
_UNITS = (("mm/s", "N"), ("mrad/s", "Nm"))
UNITS = {
    "limit": "N, Nm",
    "error_bound": "N, Nm",
    "horizon": "s",
    "environment_speed": "m/s",
    "axes.speed": "m/s, rad/s",
    "axes.excess": "N, Nm",
    "moving.factor": "1",
    "moving.response": "s",
    "moving.acceleration": "m/s2, rad/s2",
    "moving.stiffness": "N/m, N/rad, Nm/m, Nm/rad",
}
"""Of the numbers in the map for programs: of forces first, of torques behind the comma."""
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


def _bound(parameters: ControllerParameters, limit: Array, turn: float, rotation: Array = _PARALLEL) -> StiffnessBound:
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
            (caps.levels[0][j] / (bound.rows[j][axis] * parameters.horizon), f"limit {AXES[j]}") for j in range(6)
        ]
        own = caps.levels[2][axis] / (bound.rows[axis][axis] * parameters.horizon)
        slowest = min(fastest, *allowed, (own, f"limit {AXES[axis]} less the reserve"))
    return float(slowest[0]), slowest[1]


def as_map(
    parameters: ControllerParameters,
    limit: Array,
    error_bound: Array,
    environment_speed: float = 0.1,
    rotations: Sequence[Array] = (_PARALLEL,),
) -> dict[str, Any]:
    """The certificates for programs, as JSON has them, and what the excess in a moving environment follows from.

    Args:
        parameters: of the controller.
        limit: wbar (6,) [N, Nm].
        error_bound: eps (6,) [N, Nm].
        environment_speed: [m/s], in whatever direction.
        rotations: each (3, 3), of the tool in base, to give Kbar (6, 6) for.

    Raises:
        ValueError: if the limits cannot be kept with such errors; the text says why.
    """
    found = certificates(parameters, limit, error_bound, environment_speed)
    return {
        "units": UNITS,
        "form": _form(parameters),
        "limit": limit.tolist(),
        "error_bound": error_bound.tolist(),
        "horizon": parameters.horizon,
        "environment_speed": environment_speed,
        "axes": [vars(one) for one in found],
        "moving": {
            "factor": MOVING_FACTOR,
            "response": response(parameters),
            "acceleration": list(parameters.max_acceleration),
            "stiffness": [stiffness(parameters, limit, rotation).tolist() for rotation in rotations],
        },
    }


@dataclass(frozen=True)
class Statement:
    """The certificates for a person: sentences, a table with its head, sentences below it."""

    before: tuple[str, ...]
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    after: tuple[str, ...]


def as_words(
    parameters: ControllerParameters, limit: Array, error_bound: Array, environment_speed: float = 0.1
) -> Statement:
    """The certificates for a person; arguments and errors as of ``certificates``."""
    found = certificates(parameters, limit, error_bound, environment_speed)
    before = [
        f"certified law, {_form(parameters)}; T {parameters.period * 1e3:g} ms, d {parameters.delay * 1e3:g} ms, "
        f"tau {parameters.lag * 1e3:g} ms: a command has acted {parameters.horizon * 1e3:g} ms after its sample"
    ]
    for zone in parameters.contact_zones:
        reach = ", ".join(f"{length:g}" for length in zone.reach)
        before.append(
            f"contacts up to {zone.stiffness:g} N/m within ({reach}) m of the tool, friction {zone.friction:g}"
        )
    before.append(
        "While environment and base are at rest, no limit is exceeded: from first touch on, between samples too."
    )
    rows = []
    for index, one in enumerate(found):
        speed_unit, unit = _UNITS[index // 3]
        share = one.excess / limit[index]
        row = (
            one.axis,
            f"{limit[index]:g} {unit}",
            f"{error_bound[index]:g} {unit}",
            f"{one.speed * 1e3:.3g} {speed_unit}",
            one.limited_by,
            f"{one.excess:.3g} {unit} ({share:.0%} of the limit)",
        )
        rows.append(row)
    timing = {"period T": parameters.period, "delay d": parameters.delay, "lag tau": parameters.lag}
    name, longest = max(timing.items(), key=lambda item: item[1])
    after = (
        f"Speeds scale with 1/(stiffness x {parameters.horizon * 1e3:g} ms); the largest share of the time is the "
        f"{name} ({longest / parameters.horizon:.0%}).",
        f"Excess, measured and not proven: {MOVING_FACTOR:g} x stiffness x speed of the environment x (response time + "
        "time to speed up), beyond the limit, until the tool moves with it.",
    )
    head = ("axis", "limit", "error", "certified approach", "limited by", f"excess at {environment_speed:g} m/s")
    return Statement(tuple(before), head, tuple(rows), after)


def _form(parameters: ControllerParameters) -> str:
    return "strict" if parameters.yield_start == 1.0 else f"rounded (yield_start {parameters.yield_start:g})"
