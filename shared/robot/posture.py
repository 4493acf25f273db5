"""The posture that an arm's redundancy is drawn back to while the tool moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shared.spatial import Array


@dataclass(frozen=True)
class Lift:
    """A joint that goes up and down with the tool, so that the rest of the arm need not.

    Attributes:
        joint: its place in the chain.
        bottom: its position [m] all the way down.
        lowest: height [m] of the tool at which it is there; above they share the way.
        tool: height [m] of the tool in the home posture.
    """

    joint: int
    bottom: float
    lowest: float
    tool: float


class Posture:
    """Home posture, but for a lift.

    Args:
        home: positions (n,) [m, rad].
        lift: if there is one.
    """

    def __init__(self, home: Array, lift: Lift | None = None) -> None:
        self._home = home
        self._lift = lift
        if lift is not None:
            self._share = (home[lift.joint] - lift.bottom) / (lift.tool - lift.lowest)

    def at(self, height: float, rising: float) -> tuple[Array, Array]:
        """Posture (n,) [m, rad] to return to, and its own velocity (n,).

        Args:
            height: of the tool [m].
            rising: its wanted velocity upwards [m/s].
        """
        reference, lead = self._home.copy(), np.zeros(len(self._home))
        if (lift := self._lift) is not None:
            place = lift.bottom + self._share * (height - lift.lowest)
            reference[lift.joint] = min(max(place, lift.bottom), self._home[lift.joint])
            if reference[lift.joint] == place:
                lead[lift.joint] = self._share * rising
        return reference, lead
