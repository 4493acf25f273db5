"""How old the bias in force is.

A sensor's zero belongs to one run of the robot process. Within it the stamps of the sensor's own samples tell the age:
they are of one steady clock, which goes on while this service is stopped, starved or started anew.
"""

from __future__ import annotations

import math

from services.wrench.error_bound import NO_ZERO
from shared.clock import nanoseconds, seconds
from shared.service import LONGEST_DT


class Zero:
    """Age of the bias in force.

    Attributes:
        since: stamp [ns] at which it began to be measured, in the present run; None without a zero of this run.
        stamp: of the last sample [ns].
    """

    def __init__(self) -> None:
        self.since: int | None = None
        self.stamp = 0
        self._silence = 0.0

    @property
    def age(self) -> float:
        """Age [s] at the last sample, or `NO_ZERO`."""
        return NO_ZERO if self.since is None else max(0.0, seconds(self.stamp - self.since))

    def sampled(self, stamp: int) -> None:
        """Another sample of this run, with its stamp [ns]."""
        self.stamp, self._silence = stamp, 0.0

    def silent(self, dt: float) -> None:
        """Time [s] has passed without a sample; the loop tells no more than `LONGEST_DT`, whatever it was."""
        self._silence += dt if dt < LONGEST_DT else math.inf

    def restarted(self, stamp: int, dt: float, survives: bool) -> None:
        """The robot process was started anew: its first sample has this stamp [ns], ``dt`` [s] after the last call.

        Args:
            stamp: of the new run.
            dt: since the last call of any kind.
            survives: the sensor keeps its zero meanwhile; it is lost all the same if it is not known for how long.
        """
        self.silent(dt)
        known = survives and self.since is not None and self._silence < math.inf
        self.since = stamp - nanoseconds(self.age + self._silence) if known else None
