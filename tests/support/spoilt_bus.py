"""A robot in real time, and a bus on which it misbehaves: something else is sent in place of what it says."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterable

from shared.clock import SteadyClock, seconds
from shared.loop.runner import Runner
from shared.service import Service
from shared.wire.links import Links
from shared.wire.zenoh import ZenohBus

Spoil = Callable[[str, bytes], Iterable[bytes]]
"""What is sent in place of a payload under a key."""


class SpoiltBus(ZenohBus):
    """A bus on which something else is sent in place of each payload.

    Attributes:
        spoil: says what; None: the payload itself.
        last_sent_ns: by key, when the last sound payload left.
    """

    def __init__(self, endpoint: str, spoil: Spoil | None = None, links: Links | None = None) -> None:
        super().__init__(connect=endpoint, links=links, watched=True)
        self.link()
        self.spoil = spoil
        self.last_sent_ns: defaultdict[str, int] = defaultdict(int)

    def publish(self, key: str, payload: bytes) -> None:
        """Send what ``spoil`` makes of a payload."""
        for sent in self.spoil(key, payload) if self.spoil else (payload,):
            super().publish(key, sent)
            if sent == payload:
                self.last_sent_ns[key] = time.monotonic_ns()


def live(service: Service, bus: ZenohBus, ended: Callable[[], bool]) -> None:
    """Run a service that a timer drives, in this thread and in real time, until it is to end."""
    clock = SteadyClock()
    runner = Runner(service, bus, clock)
    while not ended():
        time.sleep(max(0.0, seconds(runner.next_deadline() - clock.now_ns())))
        runner.poll()
