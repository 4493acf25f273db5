"""What the certified law allows beyond its limits while its environment moves (docs/guarantee.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from services.controller import guarantee
from services.controller.parameters import ControllerParameters
from shared.parameters import Refused
from shared.spatial import rotation_matrix


@dataclass(frozen=True)
class Certified:
    """What the guarantee says of a controller's configuration.

    Attributes:
        response: time [s] from a sample until the answer to it has acted.
        acceleration: (6,) [m/s2, rad/s2] of the tool when it speeds up.
        attitudes: (k, 4) of the tool in base, for which there is
        stiffness: Kbar (k, 6, 6), in base axes [N/m, N/rad, Nm/m, Nm/rad].
    """

    response: float
    acceleration: np.ndarray
    attitudes: np.ndarray
    stiffness: np.ndarray

    @classmethod
    def of(cls, settings: Mapping[str, Any], limit: np.ndarray, error: np.ndarray, attitudes: np.ndarray) -> Certified:
        """The guarantee of a configuration.

        Args:
            settings: the controller's parameters that differ from the defaults.
            limit: (6,) [N, Nm].
            error: (6,) bound on the wrench's error [N, Nm].
            attitudes: (k, 4) of the tool in base that are of interest.

        Raises:
            ValueError: there is none; the text says why.
        """
        try:
            parameters = ControllerParameters.of(settings)
        except Refused as problem:
            raise ValueError(str(problem)) from None
        guarantee.certificates(parameters, limit, error)
        rotations = [rotation_matrix(attitude) for attitude in attitudes]
        return cls(
            response=guarantee.response(parameters),
            acceleration=np.array(parameters.max_acceleration),
            attitudes=attitudes,
            stiffness=np.array([guarantee.stiffness(parameters, limit, rotation) for rotation in rotations]),
        )

    def excess(self, twist: np.ndarray, attitude: np.ndarray) -> np.ndarray:
        """Expected worst excess (n, 6) [N, Nm] over the limits.

        ``c * sum_j Kbar_ij |u_j| (D + |u_j| / 2 a_j)``: the growth until the tool can have followed.

        Args:
            twist: |u| (n, 6) [m/s, rad/s] of the environment relative to the base, at the tool's origin.
            attitude: (n,) which of `attitudes` the tool has.
        """
        travel = twist * (self.response + twist / (2.0 * self.acceleration))
        return guarantee.MOVING_FACTOR * np.einsum("nij,nj->ni", self.stiffness[attitude], travel)
