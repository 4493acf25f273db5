"""A recording service in a simulated stack, its inputs, and everything that it commands."""

from __future__ import annotations

from collections.abc import Callable

from shared.faults import FaultKind
from shared.loop.stack import Stack
from shared.messages import TwistCommand
from shared.schema.records import Record
from shared.topics import COMMAND_EE_TWIST, STATE_EE, WRENCH_EXTERNAL, Topic
from tests.shared.rig import Recorder, Source, speed, tool, wrench


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
        return Source(self.stack.scheduler, self.stack.bus, topic, make, period)

    def working(self) -> tuple[Source, Source]:
        inputs = self.source(WRENCH_EXTERNAL, wrench), self.source(STATE_EE, tool)
        self.stack.run(1.0)
        assert self.runner.fault is None
        self.service.calls.clear()
        self.service.steps.clear()
        self.service.brakes.clear()
        self.commands.clear()
        return inputs

    def first_brake(self) -> tuple[float, FaultKind]:
        when = next(now for now, message, _ in self.commands if speed(message) == 0.0)
        return when, self.service.brakes[0][0].kind
