"""A clock that a test moves, a publisher whose header a test bends, a service that records what the loop asks of it."""

from __future__ import annotations

from collections.abc import Callable

from shared.clock import nanoseconds
from shared.faults import FaultKind
from shared.messages import ControlTarget, EndEffector, ExternalWrench, FtSample, Header
from shared.schema.records import Record
from shared.topics import SENSOR_FT, Topic
from shared.wire.codec import encode
from shared.wire.subscription import Received, Subscription

LEVEL = (0.0, 0.0, 0.0, 1.0)
ZERO = (0.0, 0.0, 0.0)


class ManualClock:
    """Stands still until moved."""

    def __init__(self, now: float = 100.0) -> None:
        self.now = nanoseconds(now)

    def now_ns(self) -> int:
        return self.now

    def advance(self, duration: float) -> None:
        self.now += nanoseconds(duration)


def ft_sample(force: float = 0.0) -> FtSample:
    return FtSample((force, 0.0, 0.0), ZERO, LEVEL, ZERO, False)


def wrench(force: float = 0.0, fault: str = "") -> ExternalWrench:
    return ExternalWrench((force, 0.0, 0.0), ZERO, (0.0,) * 6, "tare", fault)


def tool() -> EndEffector:
    return EndEffector(ZERO, LEVEL, ZERO, ZERO)


def target() -> ControlTarget:
    return ControlTarget(ZERO, LEVEL, (25.0,) * 3, (10.0,) * 3)


class Publisher:
    """Makes the payloads of one session; its steady clock has an epoch of its own [s]."""

    def __init__(self, clock: ManualClock | None = None, session: int = 1, epoch: float = 0.0) -> None:
        self._clock = clock or ManualClock()
        self._epoch_ns = nanoseconds(epoch)
        self.session = session
        self.seq = 0

    def stamp(self) -> int:
        return self._clock.now_ns() + self._epoch_ns

    def payload(self, message: Record, valid: bool = True, seq: int | None = None, stamp: int | None = None) -> bytes:
        if seq is None:
            seq, self.seq = self.seq, self.seq + 1
        return encode(message, Header(seq, self.session, self.stamp() if stamp is None else stamp, valid))


DECLARED_DELAY = 0.02


class Feed:
    """A subscription, its clock and a first publisher at 100 Hz."""

    def __init__(self, topic: Topic = SENSOR_FT, make: Callable[[], Record] = ft_sample, period: float = 0.01) -> None:
        self.clock = ManualClock()
        self.received: list[Received] = []
        self.subscription = Subscription(topic, self.clock, self.received.append)
        self.make = make
        self.period = period
        self.first = Publisher(self.clock, session=1, epoch=5000.0)

    def run(self, count: int, publisher: Publisher | None = None) -> None:
        for _ in range(count):
            self.clock.advance(self.period)
            self.subscription.offer((publisher or self.first).payload(self.make()))

    def offer(self, publisher: Publisher | None = None, force: float = 0.0, **header: int | None) -> None:
        """A sample of the sensor now, with some of its header as given."""
        self.subscription.offer((publisher or self.first).payload(ft_sample(force), **header))

    def fault(self) -> FaultKind | None:
        fault = self.subscription.fault(self.clock.now, DECLARED_DELAY)
        return None if fault is None else fault.kind
