"""Several services in one process under a simulated clock: deterministic and many times faster than real time."""

from __future__ import annotations

from collections.abc import Callable

from shared.clock import nanoseconds
from shared.loop.runner import Runner
from shared.service import Service
from shared.wire.client import Client
from shared.wire.local import LocalBus, Scheduler


class Stack:
    """A scheduler, its bus, and the services that were added.

    Args:
        latency: time [s] that every message takes.
    """

    def __init__(self, latency: float = 0.0) -> None:
        self.scheduler = Scheduler()
        self.bus = LocalBus(self.scheduler, latency)
        self.client = Client(self.bus, self.scheduler.clock)
        self._due: dict[int, int] = {}
        self._killed: set[int] = set()

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self.scheduler.clock.now_ns() * 1e-9

    def add(self, service: Service) -> Runner:
        """Connect a service and keep it running."""
        runner: Runner | None = None

        def poll() -> None:
            assert runner is not None
            if id(runner) in self._killed:
                return
            runner.poll()
            self._plan(runner, poll)

        runner = Runner(service, self.bus, self.scheduler.clock, wake=lambda: self.scheduler.soon(poll))
        self._plan(runner, poll)
        return runner

    def kill(self, runner: Runner) -> None:
        """Let a service do nothing any more, not even brake, as if its process had been killed."""
        self._killed.add(id(runner))

    def _plan(self, runner: Runner, poll: Callable[[], None]) -> None:
        """Poll at the next deadline, once, however often the runner was polled before it."""
        deadline = runner.next_deadline()
        planned = self._due.get(id(runner))
        if planned is not None and self.scheduler.clock.now_ns() < planned <= deadline:
            return
        self._due[id(runner)] = deadline
        self.scheduler.at(deadline, poll)

    def run(self, duration: float, done: Callable[[], bool] = lambda: False) -> None:
        """Let ``duration`` [s] of simulated time pass, or less if ``done`` says so."""
        self.scheduler.run_until(self.scheduler.clock.now_ns() + nanoseconds(duration), done)
