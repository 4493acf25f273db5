"""Simulated time and a bus inside one process: deterministic, and as fast as the services compute."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from functools import partial

from shared.clock import nanoseconds
from shared.wire.bus import Leave, NoReply, OnPayload, OnRequest, Work


class SimulatedClock:
    """A clock that a scheduler moves."""

    def __init__(self) -> None:
        self._now = 0

    def now_ns(self) -> int:
        """Simulated time [ns]."""
        return self._now

    def advance_to(self, time_ns: int) -> None:
        """Move forward to a time [ns]; a time already past leaves the clock where it is."""
        self._now = max(self._now, time_ns)


class Scheduler:
    """Runs actions in the order of their simulated times; ties in the order in which they were asked for."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self._queue: list[tuple[int, int, Callable[[], None]]] = []
        self._count = 0

    def at(self, time_ns: int, action: Callable[[], None]) -> None:
        """Run an action at a simulated time [ns]."""
        self._count += 1
        heapq.heappush(self._queue, (time_ns, self._count, action))

    def soon(self, action: Callable[[], None]) -> None:
        """Run an action at the present time, after everything already due."""
        self.at(self.clock.now_ns(), action)

    def run_until(self, time_ns: int, done: Callable[[], bool] = lambda: False) -> None:
        """Run everything due up to a time [ns], or until ``done`` says so."""
        while self._queue and self._queue[0][0] <= time_ns:
            due, _, action = heapq.heappop(self._queue)
            self.clock.advance_to(due)
            action()
            if done():
                return
        self.clock.advance_to(time_ns)


class LocalBus:
    """The bus of services that share a process and a simulated clock.

    Args:
        scheduler: delivers the payloads.
        latency: time [s] from publishing to delivery.
    """

    def __init__(self, scheduler: Scheduler, latency: float = 0.0) -> None:
        self._scheduler = scheduler
        self._latency_ns = nanoseconds(latency)
        self._subscribers: dict[str, tuple[OnPayload, ...]] = {}
        self._servers: dict[str, OnRequest] = {}
        self._living: set[str] = set()
        self._present: dict[int, str] = {}

    def publish(self, key: str, payload: bytes) -> None:
        """Deliver after the latency, in order."""
        if key in self._subscribers:
            due = self._scheduler.clock.now_ns() + self._latency_ns
            self._scheduler.at(due, partial(_deliver, self._subscribers[key], payload))

    def wanted(self, key: str) -> bool:
        """Whether anybody subscribes to the key."""
        return key in self._subscribers

    def subscribe(self, key: str, on_payload: OnPayload, work: Work | None = None) -> None:
        """Have every payload under the key handed over; in simulated time no work lasts."""

        def and_work(payload: bytes) -> None:
            on_payload(payload)
            assert work is not None
            work(False)

        take = on_payload if work is None else and_work
        self._subscribers[key] = (*self._subscribers.get(key, ()), take)

    def listen(self, key: str, on_payload: OnPayload) -> Leave:
        """Subscribe until what is returned is called."""
        self.subscribe(key, on_payload)

        def leave() -> None:
            left = list(self._subscribers.pop(key))
            left.remove(on_payload)
            if left:
                self._subscribers[key] = tuple(left)

        return leave

    def serve(self, key: str, on_request: OnRequest) -> None:
        """Answer queries under the key."""
        self._servers[key] = on_request

    def query(self, key: str, payload: bytes, timeout: float) -> bytes:
        """Ask, and let simulated time pass until the answer is there; not from inside a scheduled action.

        Raises:
            NoReply: if none came within ``timeout`` [s] of simulated time.
        """
        replies: list[bytes] = []
        if key in self._servers:
            self._servers[key](payload, replies.append)
            deadline = self._scheduler.clock.now_ns() + nanoseconds(timeout)
            self._scheduler.run_until(deadline, done=lambda: bool(replies))
        if not replies:
            raise NoReply(f"no answer on {key} within {timeout:g} s")
        return replies[0]

    def query_later(self, key: str, payload: bytes, on_reply: OnPayload) -> bool:
        """Ask from inside a scheduled action; False if nobody serves the key."""
        if key not in self._servers:
            return False
        self._servers[key](payload, on_reply)
        return True

    def claim(self, name: str, session: int) -> Leave:
        """Count one start of a participant as present, until what is returned is called."""
        self._present[session] = name

        def leave() -> None:
            del self._present[session]

        return leave

    def alive(self, name: str, session: int) -> None:
        """Count the service as living, and this start of it as present."""
        self._living.add(name)
        self.claim(name, session)

    def living(self) -> set[str]:
        """Names of the living services."""
        return set(self._living)

    def sessions(self, name: str) -> set[int]:
        """Starts of a participant that are present."""
        return {session for session, other in self._present.items() if other == name}

    def present(self) -> Mapping[int, str]:
        """Name of the participant by session."""
        return dict(self._present)

    def connected(self) -> bool:
        """Always: within a process nothing comes between."""
        return True

    def links(self) -> dict[str, bool]:
        """None: there is nothing but this bus."""
        return {}

    def cut_off(self) -> str:
        """Never."""
        return ""

    def close(self) -> None:
        """Forget everybody."""
        self._subscribers.clear()
        self._servers.clear()
        self._living.clear()
        self._present.clear()


def _deliver(subscribers: tuple[OnPayload, ...], payload: bytes) -> None:
    for on_payload in subscribers:
        on_payload(payload)
