"""When braking needs a person to end it."""

from __future__ import annotations

from shared.faults import Fault, FaultKind
from shared.topics import WRENCH_EXTERNAL

SENSOR_WORDS = ("silent", "stuck", "saturated")
"""Faults of the sensor itself, as the wrench service names them; "invalid" is the transport's."""
LATCH_AFTER = 0.1
"""Duration [s] of a sensor's fault from which on braking is latched."""


class SensorLatch:
    """Latches a failure of the force sensor that the rest of the robot survives.

    A robot whose topics are all silent (restarted, network cut) shows as silence of ``state/ee``, which is the more
    fundamental fault and latches nothing: it recovers by itself.

    Attributes:
        reason: why braking is latched, empty if it is not.
    """

    def __init__(self) -> None:
        self.reason = ""
        self._lasting: float | None = None

    def fault(self, fault: Fault, dt: float) -> None:
        """Note a fault that is present, ``dt`` [s] after the last call of any kind."""
        if not (
            fault.kind is FaultKind.INVALID
            and fault.key == WRENCH_EXTERNAL.key
            and fault.word in SENSOR_WORDS
        ):
            self._lasting = None
            return
        self._lasting = 0.0 if self._lasting is None else self._lasting + dt
        if self._lasting >= LATCH_AFTER and not self.reason:
            self.reason = (
                f"the force sensor was {fault.word} for more than {LATCH_AFTER * 1e3:.0f} ms: "
                "latched, release with `tandem resume`"
            )

    def healthy(self) -> None:
        """No fault is present."""
        self._lasting = None

    def release(self) -> None:
        """A person has seen to it."""
        self.reason = ""
