"""A region of contacts, as it is configured and as the stiffness bound counts it."""

from __future__ import annotations

import math

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from shared.parameters import Vector3


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class ContactZone:
    """A region around the tool in which contacts may lie; ``[[controller.zones]]`` of a configuration file.

    Attributes:
        stiffness: kappa [N/m], largest sum of the stiffnesses of all contacts in the zone.
        reach: (3,) [m] farthest contact from the tool's origin along each tool axis.
        friction: mu [1], Coulomb coefficient; 0 for contacts that stick or are frictionless.

    Raises:
        ValueError: if a number is missing, not finite or negative.
    """

    stiffness: float
    reach: Vector3
    friction: float = 0.0

    def __post_init__(self) -> None:
        numbers = (self.stiffness, *self.reach, self.friction)
        if not all(math.isfinite(number) and number >= 0.0 for number in numbers):
            raise ValueError(f"a contact zone needs finite numbers >= 0, got {list(numbers)}")

    @property
    def amplification(self) -> float:
        """``m = sqrt(1 + mu^2)``: how much friction lengthens a contact's force."""
        return math.sqrt(1.0 + self.friction**2)
