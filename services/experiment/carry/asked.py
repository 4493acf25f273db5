"""What was asked for while the panel was held: the limits by which the wrench is judged, against the stated ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.carry.carry_protocol import FORCE_LIMIT, TORQUE_LIMIT
from services.experiment.carry.excess import Wrenches

STATED = np.array(FORCE_LIMIT + TORQUE_LIMIT)  # [N, Nm]
_Z = 2


@dataclass(frozen=True)
class Asked:
    """Of `control/target`, at every sample of the wrench.

    Attributes:
        off: largest difference of a limit to the stated one [N, Nm].
        lowest, highest: nominal force along z [N].
        other: largest nominal force or torque on any other axis [N, Nm].
    """

    off: float
    lowest: float
    highest: float
    other: float


def asked(wrenches: Wrenches) -> Asked:
    """What was asked for in a span in which the panel was held."""
    carried = wrenches.nominal[:, _Z]
    return Asked(
        off=float(np.abs(wrenches.limit - STATED).max(initial=0.0)),
        lowest=float(carried.min(initial=0.0)),
        highest=float(carried.max(initial=0.0)),
        other=float(np.abs(np.delete(wrenches.nominal, _Z, axis=1)).max(initial=0.0)),
    )
