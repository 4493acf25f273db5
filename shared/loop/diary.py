"""When a service took what: each arrival and each turn of its loop, noted as it happens and told now and then.

With the messages of a recording, which arrive there at other moments, that is all that a replay needs to take the very
same steps.
"""

from __future__ import annotations

import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from shared.requests import Setup
from shared.topics import MAP_CAP

if TYPE_CHECKING:
    from shared.service import Service

_ENTRY = struct.Struct("<bqI")
_KEPT = 8000
"""Entries that wait to be told, some seconds' worth; of more the oldest are forgotten."""
BEGUN, TURN, TURN_BEHIND, DONE = -1, -2, -3, -4


class Entry(NamedTuple):
    """Something that happened.

    Attributes:
        what: ``BEGUN``: the loop was made; ``TURN``, or ``TURN_BEHIND`` if a message came during the one before: it
            looked for what was due; ``DONE``: a step or a brake was over; else the number of the input that came.
        time: when, by the service's clock [ns].
        mark: of an arrival, the check sum of its payload.
    """

    what: int
    time: int
    mark: int = 0


def mark_of(payload: bytes) -> int:
    """Check sum by which an arrival is found again among the payloads of its key."""
    return zlib.crc32(payload)


class Diary:
    """Notes from any thread.

    Attributes:
        keys: of the inputs, by their numbers.
    """

    def __init__(self, now: int) -> None:
        self.keys: list[str] = []
        self._entries: deque[tuple[int, int, int]] = deque([(BEGUN, now, 0)], maxlen=_KEPT)

    def input(self, key: str) -> Callable[[int, bytes], None]:
        """What notes each arrival under a key, given when [ns] and its payload."""
        if key not in self.keys:
            self.keys.append(key)
        number, entries = self.keys.index(key), self._entries
        return lambda arrival, payload: entries.append((number, arrival, zlib.crc32(payload)))

    def turn(self, now: int, behind: bool) -> None:
        """Note that the loop looks for what is due."""
        self._entries.append((TURN_BEHIND if behind else TURN, now, 0))

    def done(self, now: int) -> None:
        """Note that a step is over."""
        self._entries.append((DONE, now, 0))

    def told(self) -> bytes:
        """What was noted since the last call."""
        parts = []
        for _ in range(len(self._entries)):
            parts.append(_ENTRY.pack(*self._entries.popleft()))
        return b"".join(parts)


def entries(told: bytes) -> Iterator[Entry]:
    """What a diary told, in the order in which it was noted; an entry that is cut off is left out."""
    whole = len(told) - len(told) % _ENTRY.size
    return (Entry(*values) for values in _ENTRY.iter_unpack(told[:whole]))


def setup(service: Service, diary: Diary, key: str, request: bytes) -> Setup:
    """What a service works by, what it took since it told that last, and the request that it has taken up just now."""
    parameters = service.parameters
    chosen = tuple(sorted(parameters.model_fields_set))
    kept = bytes(request) if len(request) <= MAP_CAP else b""
    return Setup(parameters.values(), chosen, dict(service.files()), key, kept, tuple(diary.keys), diary.told())
