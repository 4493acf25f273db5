"""A service loop whose steps take time: the clock moves while they compute."""

from __future__ import annotations

from shared.loop.runner import Runner
from shared.topics import STATE_EE, WRENCH_EXTERNAL
from shared.wire.local import LocalBus, Scheduler
from tests.shared.rig import ManualClock, Publisher, Recorder, tool, wrench


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
        for topic, publisher, message in (
            (WRENCH_EXTERNAL, self.wrench, wrench()),
            (STATE_EE, self.ee, tool()),
        ):
            subscription = self.runner.subscriptions.get(topic.key)
            if subscription is not None:
                subscription.offer(publisher.payload(message, stamp=publisher.stamp() - round(age * 1e9)))

    def run(self, count: int, period: float = 0.01) -> None:
        for _ in range(count):
            self.clock.advance(period)
            self.deliver()
            self.runner.poll()

    def working(self) -> None:
        self.run(100)
        assert self.runner.fault is None
        self.service.calls.clear()
        self.service.steps.clear()
