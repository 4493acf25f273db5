"""Stands in for the processes around the one under test: publishes at a rate over a real router, and listens."""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import Self, TypeVar

import msgpack

from shared.schema.records import Record
from shared.topics import Topic, health_topic
from shared.wire.client import Client
from shared.wire.subscription import Received
from tests.support.spoilt_bus import SpoiltBus

M = TypeVar("M", bound=Record)
PERIOD = 0.01
Spoil = Callable[[bytes], bytes | None]
"""What is sent in place of a payload; None sends nothing."""


def silently(payload: bytes) -> None:
    return None


def changed(**fields: object) -> Spoil:
    """Replaces fields of a map."""
    return lambda payload: msgpack.packb({**msgpack.unpackb(payload), **fields})


SPOILT_WRENCHES: dict[str, Spoil] = {
    "NaN": changed(force=[math.nan, 0.0, 0.0]),
    "infinity": changed(error_bound=[math.inf] * 6),
    "text": changed(torque="much"),
    "too short": changed(force=[1.0]),
    "no header": changed(seq=None),
    "garbage": lambda payload: bytes(reversed(payload)),
    "empty": lambda payload: b"",
    "megabyte": lambda payload: payload + bytes(1_000_000),
}
"""Payloads of ``wrench/external`` that have to be rejected."""


class StandIn(ABC):
    """A participant that publishes from a thread of its own for as long as it is entered.

    Args:
        endpoint: of the router.
        service: the one under test.
        period: between two turns [s].

    Attributes:
        health: of the service, as it says.
        spoil: by key, what is sent in place of a message.
        turns: number of turns so far.
        lateness: greatest delay of a turn [s]; a test may set it back.
    """

    def __init__(self, endpoint: str, service: str, period: float = PERIOD) -> None:
        self.bus = SpoiltBus(endpoint)
        self.bus.spoil = self._spoilt
        self.client = Client(self.bus)
        self.health = self.client.watch(health_topic(service))
        self.spoil: dict[str, Spoil] = {}
        self.turns = 0
        self.lateness = 0.0
        self._period = period
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)

    @abstractmethod
    def turn(self, number: int) -> None:
        """Publish what is due."""

    def hear(self, topic: Topic[M]) -> list[Received[M]]:
        """Every message of a topic from now on, in a list that grows."""
        heard: list[Received[M]] = []
        self.client.watch(topic, heard.append)
        return heard

    def ok(self) -> bool:
        """Whether the service says that all is well."""
        return self.health.latest is not None and self.health.latest.message.state == "ok"

    def refused(self, key: str) -> int:
        """How many messages of a key the service has refused so far, as it says."""
        return self.health.latest.message.inputs[key].rejected if self.health.latest else 0

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self.bus.close()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._ended.wait(max(0.0, due - time.monotonic())):
            self.lateness = max(self.lateness, time.monotonic() - due)
            self.turns += 1
            self.turn(self.turns - 1)
            # What a held-up machine has missed is left out: made up for in one burst, it would be a flood.
            due = max(due + self._period, time.monotonic())

    def _spoilt(self, key: str, payload: bytes) -> Iterable[bytes]:
        spoil = self.spoil.get(key)
        sent = spoil(payload) if spoil else payload
        return () if sent is None else (sent,)
