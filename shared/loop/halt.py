"""Stops and latched sensor failures: a service rests until a person ends that, with healthy inputs too."""

from __future__ import annotations

from shared.faults import Fault, FaultKind
from shared.service import Inputs
from shared.topics import STATE_EE, STOP, WRENCH_EXTERNAL

SENSOR_WORDS = ("silent", "stuck", "saturated")
"""Faults of the sensor itself, as the wrench service names them; "invalid" is the transport's."""
LATCH_AFTER = 0.1
"""Duration [s] of a sensor's fault after which braking is latched."""
_ROBOT_SILENT_BY = STATE_EE.max_age + 0.025
"""Time [s] since the last healthy wrench by which a robot that is gone shows as silence of ``state/ee``, whose last
message may be a period younger."""
_CONFIRMED_BY = 2
"""So many times the sensor has to be blamed: a process that wakes up from a pause blames it once, for its own sleep."""


class SensorLatch:
    """Latches a failure of the force sensor that the rest of the robot survives.

    The failure begins with the last healthy wrench and lasts through whatever is reported of the wrench: between two
    of the wrench service's sparse messages about a silent sensor the wrench itself counts as silent. Silence that
    nobody blames on the sensor latches nothing, and neither does a robot whose topics are all silent (restarted,
    network cut): it shows as a fault of ``state/ee``, the more fundamental one, and recovers by itself.

    Attributes:
        reason: why braking is latched, empty if it is not.
    """

    def __init__(self) -> None:
        self.reason = ""
        self._lasting = 0.0
        self._blamed = 0
        self._word = ""

    def fault(self, fault: Fault, dt: float) -> None:
        """Note a fault that is present, ``dt`` [s] after the last call of any kind."""
        if fault.key != WRENCH_EXTERNAL.key:
            # The robot is gone, or the loop reports a trouble of its own, which it does with healthy inputs only.
            self.healthy()
            return
        self._lasting += dt
        if fault.kind is FaultKind.INVALID and fault.word in SENSOR_WORDS:
            self._blamed += 1
            self._word = fault.word
        if self._lasting >= max(LATCH_AFTER, _ROBOT_SILENT_BY) and self._blamed >= _CONFIRMED_BY and not self.reason:
            self.reason = (
                f"the force sensor was {self._word} for more than {LATCH_AFTER * 1e3:.0f} ms: "
                "latched, release with `tandem resume`"
            )

    def healthy(self) -> None:
        """No fault of the wrench is present."""
        self._lasting, self._blamed = 0.0, 0

    def release(self) -> None:
        """A person has seen to it."""
        self.reason = ""


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
