"""A bus on which a robot misbehaves: something else is sent in place of what it says."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from shared.bus_zenoh import ZenohBus
from shared.topics import SENSOR_FT

Spoil = Callable[[str, bytes], Iterable[bytes]]


def healthy(_key: str, payload: bytes) -> Iterable[bytes]:
    """The payload as it is."""
    return (payload,)


class SpoiltBus(ZenohBus):
    """A bus on which something else is sent in place of each payload.

    Attributes:
        spoil: says what.
        last_sent_ns: when the last sound force-torque sample left.
    """

    def __init__(self, endpoint: str) -> None:
        super().__init__(connect=endpoint)
        self.spoil: Spoil = healthy
        self.last_sent_ns = 0

    def publish(self, key: str, payload: bytes) -> None:
        """As the bus does, but for what is spoilt."""
        spoilt = tuple(self.spoil(key, payload))
        for sent in spoilt:
            super().publish(key, sent)
        if key == SENSOR_FT.key and payload in spoilt:
            self.last_sent_ns = time.monotonic_ns()
