"""What a robot's process and people put on the bus, with the time of each message and query."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgpack

from shared.requests import Setup
from shared.topics import topic_by_key
from shared.wire.codec import decode
from shared.wire.log import Log

LATENCY_NS = 500_000
"""Time [ns] of every message, about what the router takes."""


@dataclass(frozen=True)
class Event:
    """One message or query.

    Attributes:
        time: simulated [ns], when it was sent.
        key: of the topic or the query.
        content: the whole map; a message's header is part of it.
        asked: it is a query.
    """

    time: int
    key: str
    content: dict[str, Any]
    asked: bool = False


def events(path: Path, keys: tuple[str, ...]) -> Iterator[Event]:
    """What a recording has under these keys, and what services say that they were asked."""
    for one in Log(path):
        if one.key in keys:
            yield Event(one.arrival_ns - LATENCY_NS, one.key, msgpack.unpackb(one.payload))
        elif one.key.startswith("setup/"):
            topic = topic_by_key(one.key)
            assert topic is not None
            header, setup = decode(topic.message, one.payload, topic.cap)
            assert isinstance(setup, Setup)
            if setup.query and not setup.query.startswith("sim/"):
                yield Event(header.stamp, setup.query, msgpack.unpackb(setup.request), asked=True)
