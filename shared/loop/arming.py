"""When a service may begin to work, or begin again: after its inputs were healthy for a while."""

from __future__ import annotations

from shared import faults
from shared.clock import nanoseconds, seconds
from shared.faults import Fault

REARM_AFTER = 0.1
"""A fault, or an absence of the loop itself, that lasts longer than this [s] has to be followed by healthy inputs for
the whole start-up time."""


class Arming:
    """Keeps account of how long the required inputs have been healthy.

    Args:
        now_ns: receiver's clock [ns].
        startup: time [s] that they have to be healthy for; without required inputs there is nothing to wait for.
        needed: whether there are required inputs.
    """

    def __init__(self, now_ns: int, startup: float, needed: bool) -> None:
        self._startup = startup
        self._needed = needed
        self._armed = not needed
        self._healthy_since: int | None = None
        self._faulty_since: int | None = now_ns

    def restart(self) -> None:
        """Begin anew, as when an input comes from another session than before."""
        self._armed, self._healthy_since = not self._needed, None

    def judge(self, now_ns: int, fault: Fault | None) -> Fault | None:
        """The fault itself, or that the service still has to wait, or None: it may work.

        Args:
            now_ns: receiver's clock [ns].
            fault: the most fundamental one of the inputs and the loop at present.
        """
        if fault is not None:
            self._faulty_since = now_ns if self._faulty_since is None else self._faulty_since
            self._healthy_since = None
            if now_ns - self._faulty_since > nanoseconds(REARM_AFTER):
                self.restart()
            return fault
        self._faulty_since = None
        if not self._armed:
            self._healthy_since = now_ns if self._healthy_since is None else self._healthy_since
            left = self._startup - seconds(now_ns - self._healthy_since)
            if left > 0:
                return faults.arming(left)
            self._armed = True
        return None
