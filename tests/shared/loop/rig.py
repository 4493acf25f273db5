"""A service that notes what the loop asks of it, alone in a stack, or in a loop whose steps take time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shared.clock import nanoseconds
from shared.faults import Fault, FaultKind
from shared.loop.runner import Runner
from shared.loop.stack import Stack
from shared.messages import TwistCommand
from shared.parameters import Parameters, Refused, parameter
from shared.requests import Tared
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_PARAMETERS,
    CONTROL_TARGET,
    STATE_EE,
    WRENCH_EXTERNAL,
    WRENCH_TARE,
    Query,
    Topic,
)
from shared.wire.local import LocalBus, Scheduler
from tests.shared.rig import ZERO, ManualClock, Publisher, tool, wrench


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

    def forget(self) -> None:
        for kept in (self.steps, self.brakes, self.calls):
            kept.clear()


class Source:
    """A healthy publisher on the in-process bus; a test silences or alters it while simulated time passes."""

    def __init__(self, stack: Stack, topic: Topic, make: Callable[[], Record], period: float = 0.01) -> None:
        self._stack, self._topic, self.make, self.period = stack, topic, make, period
        self.restart(1)
        self.on = True
        self.valid = True
        self.bend: Callable[[bytes], bytes] = lambda payload: payload
        stack.scheduler.soon(self._send)

    def _send(self) -> None:
        if self.on:
            payload = self.publisher.payload(self.make(), self.valid)
            self._stack.bus.publish(self._topic.key, self.bend(payload))
        scheduler = self._stack.scheduler
        scheduler.at(scheduler.clock.now_ns() + nanoseconds(self.period), self._send)

    def restart(self, session: int = 2) -> None:
        self.publisher = Publisher(self._stack.scheduler.clock, session)  # type: ignore[arg-type]


def speed(message: TwistCommand) -> float:
    return float(np.linalg.norm(message.linear))


class Rig:
    """A recorder in a stack, its two inputs, and everything that it commands."""

    def __init__(self, latency: float = 0.0, **wiring: object) -> None:
        self.stack = Stack(latency)
        self.service = Recorder(**wiring)
        self.commands: list[tuple[float, TwistCommand, bool]] = []
        self.stack.client.watch(
            COMMAND_EE_TWIST,
            lambda received: self.commands.append((self.stack.now, received.message, received.header.valid)),
        )
        self.runner = self.stack.add(self.service)

    def source(self, topic: Topic, make: Callable[[], Record], period: float = 0.01) -> Source:
        return Source(self.stack, topic, make, period)

    def working(self) -> Rig:
        """With both inputs, ``driver`` and ``ee``, for a second."""
        self.driver, self.ee = self.source(WRENCH_EXTERNAL, wrench), self.source(STATE_EE, tool)
        self.stack.run(1.0)
        assert self.runner.fault is None
        self.service.forget()
        self.commands.clear()
        return self

    def first_brake(self) -> tuple[float, FaultKind]:
        when = next(now for now, message, _ in self.commands if speed(message) == 0.0)
        return when, self.service.brakes[0][0].kind


class BusyLoop:
    """A runner on a clock that its own steps move, fed at 100 Hz."""

    def __init__(self, **wiring: object) -> None:
        self.clock = ManualClock()
        self.scheduler = Scheduler()
        self.service = Recorder(**wiring)
        self.bus = LocalBus(self.scheduler)
        self.runner = Runner(self.service, self.bus, self.clock)
        self.wrench, self.ee = Publisher(self.clock), Publisher(self.clock)
        self.cost = 0.0
        self.service.on_step = lambda inputs: self.clock.advance(self.cost)

    def deliver(self, age: float = 0.0) -> None:
        for topic, publisher, message in ((WRENCH_EXTERNAL, self.wrench, wrench()), (STATE_EE, self.ee, tool())):
            subscription = self.runner.subscriptions.get(topic.key)
            if subscription is not None:
                subscription.offer(publisher.payload(message, stamp=publisher.stamp() - round(age * 1e9)))

    def run(self, count: int, period: float = 0.01, cost: float = 0.0) -> None:
        """Steps at a period [s], each of which takes a time [s]."""
        self.cost = cost
        for _ in range(count):
            self.clock.advance(period)
            self.deliver()
            self.runner.poll()

    def working(self) -> BusyLoop:
        """With both inputs, for a second."""
        self.run(100)
        assert self.runner.fault is None
        self.service.forget()
        return self
