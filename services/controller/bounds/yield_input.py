"""What the forms of giving way are told in each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from services.controller.bounds.caps import Caps
from services.controller.bounds.stiffness_bound import StiffnessBound
from shared.spatial import Array

Vector = Sequence[float]


@dataclass(slots=True)
class YieldInput:
    """What a form gives way to.

    Attributes:
        wrench: w (6,) [N, Nm].
        caps: where the form begins, and the wall that no measured wrench passes at rest.
        bound: Kbar.
        speed: (6,) [m/s, rad/s] that the integral saturates at.
        displacement: (6,) [m, rad] commanded since the last step.
        response_time: D [s].
        dt: [s] since the last step.
    """

    wrench: Vector
    caps: Caps
    bound: StiffnessBound
    speed: Vector
    displacement: Array
    response_time: float
    dt: float
