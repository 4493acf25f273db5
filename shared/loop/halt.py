"""What keeps a service at rest until a person ends it, although its inputs may be healthy again."""

from __future__ import annotations

from shared.faults import Fault
from shared.loop.latch import SensorLatch
from shared.service import Inputs
from shared.topics import STOP


class Halt:
    """A stop that is engaged, and a failure of the force sensor that was latched; a release of the stop ends both."""

    def __init__(self) -> None:
        self._latch = SensorLatch()
        self._stopped: str | None = None

    def listen(self, inputs: Inputs) -> None:
        """Take in a new stop or release; called in each step, which happens with healthy inputs only."""
        stop = inputs.get(STOP)
        if stop is not None and stop.new:
            if stop.message.engaged:
                self._stopped = stop.message.reason or "no reason given"
            elif stop.header.valid:  # whoever does not trust himself may stop, but not release
                self._stopped = None
                self._latch.release()
        self._latch.healthy()

    def fault(self, fault: Fault, dt: float) -> None:
        """Note a fault that is present, ``dt`` [s] after the last call of any kind."""
        self._latch.fault(fault, dt)

    @property
    def latched(self) -> str:
        """Why braking is latched, empty if it is not."""
        return self._latch.reason

    @property
    def reason(self) -> str:
        """Why the service has to rest, empty if it need not."""
        if self._latch.reason or self._stopped is None:
            return self._latch.reason
        return f"stop is engaged: {self._stopped}"
