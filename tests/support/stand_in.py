"""Stands in for the processes around the one under test: publishes at a rate over a real router, and listens."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Self, TypeVar

import msgpack

from shared.schema.records import Record
from shared.topics import SENSOR_CAMERA, Topic, health_topic
from shared.wire.client import Client
from shared.wire.subscription import Received
from tests.support.spoilt_bus import SpoiltBus

M = TypeVar("M", bound=Record)
PERIOD = 0.01
Spoil = Callable[[bytes], Iterable[bytes]]
"""What is sent in place of a payload."""
Says = Callable[[int], Iterable[tuple[Any, ...]]]
HEADER = ("seq", "session", "stamp", "valid")


def silently(_payload: bytes) -> tuple[()]:
    return ()


def altered(payload: bytes, **fields: object) -> bytes:
    """The payload with some of its fields replaced."""
    return msgpack.packb({**msgpack.unpackb(payload), **fields})


def changed(**fields: object) -> Spoil:
    """Replaces fields of every payload."""
    return lambda payload: (altered(payload, **fields),)


def late(delay: float) -> Spoil:
    """Holds every payload back for so long [s]."""
    held: deque[tuple[float, bytes]] = deque()

    def spoil(payload: bytes) -> Iterable[bytes]:
        now = time.monotonic()
        held.append((now + delay, payload))
        while held[0][0] <= now:
            yield held.popleft()[1]

    return spoil


def _wrong(name: str, value: Any) -> Iterable[Any]:
    """Values that a field must not have, given one that it may have."""
    match value:
        case bool():
            yield from (1, "yes")
        case str() | bytes():
            yield 5
        case list() if name == "orientation":
            yield from ([math.nan, *value[1:]], value[:-1], [0.0] * 4)
        case list():
            yield from ([math.nan, *value[1:]], [*value[:-1], -math.inf], [*value, "much"], "much", None)
            if len(value) > 1:
                yield from (value[:-1], [*value, 0.0])
        case float():
            yield from (math.nan, math.inf, "much")
        case _:
            yield "much"


def every_spoilt(payload: bytes) -> list[bytes]:
    """A sound payload in every way spoilt that a receiver has to reject: none of them is a message."""
    content = msgpack.unpackb(payload)
    maps = [
        {**content, name: wrong}
        for name, value in content.items()
        if name not in HEADER
        for wrong in _wrong(name, value)
    ]
    first = next(name for name in content if name not in HEADER)
    maps += [{name: content[name] for name in content if name != missing} for missing in ("seq", first)]
    broken = (b"", bytes(reversed(payload)), msgpack.packb([1, 2, 3]), payload + bytes(1_000_000))
    return [*map(msgpack.packb, maps), *broken]


class StandIn:
    """A participant that publishes from a thread of its own for as long as it is entered.

    Args:
        endpoint: of the router.
        service: the one under test.
        plays: topic and message, and whether it is valid, of what is due in the turn of a number; pictures are
            published only while somebody subscribes.
        period: between two turns [s].

    Attributes:
        health: of the service, as it says.
        spoil: by key, what is sent in place of a message.
        sent: by key, the newest sound payload.
        turns: number of turns so far.
        lateness: greatest delay of a turn [s]; a test may set it back.
    """

    def __init__(self, endpoint: str, service: str, plays: Says = lambda number: (), period: float = PERIOD) -> None:
        self.bus = SpoiltBus(endpoint, self._spoilt)
        self.client = Client(self.bus)
        self.health = self.client.watch(health_topic(service))
        self.plays = plays
        self.spoil: dict[str, Spoil] = {}
        self.sent: dict[str, bytes] = {}
        self.turns = 0
        self.lateness = 0.0
        self._period = period
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)

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
            for topic, message, *valid in self.plays(self.turns - 1):
                if topic is not SENSOR_CAMERA or self.bus.wanted(topic.key):
                    self.client.publish(topic, message, *valid)
            # What a held-up machine has missed is left out: made up for in one burst, it would be a flood.
            due = max(due + self._period, time.monotonic())

    def _spoilt(self, key: str, payload: bytes) -> Iterable[bytes]:
        self.sent[key] = payload
        spoil = self.spoil.get(key)
        return spoil(payload) if spoil else (payload,)
