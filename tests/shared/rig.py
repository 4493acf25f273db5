"""A clock that a test moves, a publisher whose header a test bends, a service that records what the loop asks of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shared.clock import nanoseconds
from shared.faults import Fault, FaultKind
from shared.messages import ControlTarget, EndEffector, ExternalWrench, FtSample, Header, TwistCommand
from shared.parameters import Parameters, Refused, parameter
from shared.requests import Tared
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_PARAMETERS,
    CONTROL_TARGET,
    SENSOR_FT,
    STATE_EE,
    WRENCH_EXTERNAL,
    WRENCH_TARE,
    Query,
    Topic,
)
from shared.wire.codec import encode
from shared.wire.local import LocalBus, Scheduler
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

    def payload(
        self, message: Record, valid: bool = True, seq: int | None = None, stamp: int | None = None
    ) -> bytes:
        if seq is None:
            seq, self.seq = self.seq, self.seq + 1
        return encode(message, Header(seq, self.session, self.stamp() if stamp is None else stamp, valid))


class RecorderParameters(Parameters):
    gain: float = parameter(1.0, "1/s", 0.0, 10.0, "a number")
    limit: tuple[float, float, float] = parameter((1.0, 1.0, 1.0), "N", 0.1, 50.0, "a vector")


class Recorder(Service[RecorderParameters]):
    """A service that notes every call; ``on_step`` may raise or take its (simulated) time."""

    def __init__(self, **wiring: Any) -> None:
        defaults: dict[str, Any] = {
            "name": "recorder",
            "driver": WRENCH_EXTERNAL,
            "required": (WRENCH_EXTERNAL, STATE_EE),
            "optional": (CONTROL_TARGET,),
            "queries": (WRENCH_TARE,),
            "parameters": CONTROL_PARAMETERS,
        }
        self.wiring = Wiring(**{**defaults, **wiring})
        super().__init__(RecorderParameters())
        self.max_delay = 0.02
        self.steps: list[tuple[Inputs, float]] = []
        self.brakes: list[tuple[Fault, float]] = []
        self.calls: list[str] = []
        self.note = ""
        self.on_step: Callable[[Inputs], None] = lambda inputs: None
        self.refuses = ""
        self.on_query: Callable[[Record], Record] = lambda request: Tared(ZERO, ZERO, 7, (0.0,) * 6)

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        self.steps.append((inputs, dt))
        self.calls.append("step")
        self.on_step(inputs)
        return [Output(COMMAND_EE_TWIST, TwistCommand((1.0, 0.0, 0.0), ZERO, 0.02))]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        self.brakes.append((fault, dt))
        self.calls.append(f"brake {fault.kind.value}")
        return [Output(COMMAND_EE_TWIST, TwistCommand(ZERO, ZERO, 0.02))]

    def query(self, query: Query, request: Record, reply: Reply) -> None:
        if self.refuses:
            raise Refused(self.refuses)
        reply(self.on_query(request))

    def notes(self) -> str:
        return self.note


class Source:
    """A healthy publisher on the in-process bus; a test silences or alters it while simulated time passes."""

    def __init__(
        self,
        scheduler: Scheduler,
        bus: LocalBus,
        topic: Topic,
        make: Callable[[], Record],
        period: float = 0.01,
    ) -> None:
        self._scheduler, self._bus, self._topic, self.make = scheduler, bus, topic, make
        self.period = period
        self.publisher = Publisher(scheduler.clock)  # type: ignore[arg-type]
        self.on = True
        self.valid = True
        self.bend: Callable[[bytes], bytes] = lambda payload: payload
        scheduler.soon(self._send)

    def _send(self) -> None:
        if self.on:
            payload = self.publisher.payload(self.make(), self.valid)
            self._bus.publish(self._topic.key, self.bend(payload))
        self._scheduler.at(self._scheduler.clock.now_ns() + nanoseconds(self.period), self._send)

    def restart(self) -> None:
        self.publisher = Publisher(self._scheduler.clock, self.publisher.session + 1)  # type: ignore[arg-type]


def speed(message: TwistCommand) -> float:
    return float(np.linalg.norm(message.linear))


DECLARED_DELAY = 0.02


class Feed:
    """A subscription, its clock and a first publisher at 100 Hz."""

    def __init__(
        self, topic: Topic = SENSOR_FT, make: Callable[[], Record] = ft_sample, period: float = 0.01
    ) -> None:
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

    def fault(self) -> FaultKind | None:
        fault = self.subscription.fault(self.clock.now, DECLARED_DELAY)
        return None if fault is None else fault.kind
