"""Random contacts and the wrench they answer a motion with: the independent side of the tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from services.controller.bounds.contact_zone import ContactZone
from services.controller.bounds.stiffness_bound import StiffnessBound
from services.controller.laws.law import LawInput
from services.controller.parameters import ControllerParameters
from shared.spatial import Array, rotation_from_vector, skew

LIMIT = np.array((10.0, 10.0, 10.0, 3.0, 3.0, 3.0))
ERROR = np.array((0.1, 0.1, 0.1, 0.02, 0.02, 0.02))


def unit(rng: np.random.Generator, size: int = 3) -> Array:
    """A random direction."""
    vector = rng.normal(size=size)
    return vector / np.linalg.norm(vector)


def tangent(rng: np.random.Generator, stiffness: float, friction: float) -> Array:
    """A random contact's stiffness (3, 3) [N/m]: sticking (symmetric) or slipping (not symmetric)."""
    if rng.random() < 0.4:
        factor = rng.normal(size=(3, 3)) * rng.integers(0, 2, size=3)
        symmetric = factor @ factor.T
        return stiffness * symmetric / max(np.linalg.eigvalsh(symmetric)[-1], 1e-9)
    normal = unit(rng)
    slip = np.cross(normal, unit(rng))
    slip /= np.linalg.norm(slip)
    # Along the slip the force is mu times the normal one; across it the contact may still be elastic.
    across = np.cross(normal, slip)
    share = rng.choice((0.0, 1.0, rng.random()))
    matrix = np.outer(normal, normal) + share * np.outer(across, across) + friction * np.outer(slip, normal)
    return stiffness * matrix


def jacobian(r: Array) -> Array:
    """Velocity (3, 6) of a point at ``r`` per tool twist."""
    return np.hstack((np.eye(3), -skew(r)))


def bound(*zones: ContactZone, turn: float = 0.0, force: tuple[float, ...] = (0.0, 0.0, 0.0)) -> StiffnessBound:
    """The bound for zones around a tool whose axes are parallel to the base's."""
    found = StiffnessBound(zones)
    found.update(np.eye(3), turn, list(force))
    return found


def state(
    wrench: ArrayLike = (0.0,) * 6,
    position: ArrayLike = (0.0,) * 3,
    target: ArrayLike = (0.0,) * 3,
    turn: ArrayLike = (0.0,) * 3,
    target_turn: ArrayLike = (0.0,) * 3,
    limit: Array = LIMIT,
    error_bound: Array = ERROR,
) -> LawInput:
    """A law's input; what is not given is zero."""
    return LawInput(
        wrench=np.array(wrench, dtype=float),
        limit=limit,
        error_bound=error_bound,
        position=np.array(position, dtype=float),
        rotation=rotation_from_vector(turn),
        target_position=np.array(target, dtype=float),
        target_rotation=rotation_from_vector(target_turn),
    )


def agile(**changes: object) -> ControllerParameters:
    """Parameters without a limit on speeding up, as the paper's law is stated."""
    fast = {"max_acceleration": (1e4,) * 6, "max_linear": 1.0, "max_angular": 3.0}
    return ControllerParameters.of({**fast, "period": 0.01, "delay": 0.0, "lag": 0.0, **changes})
