"""What a robot's process and a person's tool put on the bus, with the time of each message and query."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.replay import columns
from tests.replay.columns import Place

HERE = Path(__file__).parent
INPUTS = HERE / "inputs"

_DECIMALS = {
    ("sensor/ft", "force"): 4,
    ("sensor/ft", "torque"): 5,
    ("state/ee", "linear"): 5,
    ("state/ee", "angular"): 5,
}
"""Of what has noise, so that a file stays small; everything else has `_USUAL`."""
_USUAL = 6  # a quaternion's norm is off by 1e-6 at most then, allowed are 1e-3


@dataclass(frozen=True)
class Event:
    """One message or query.

    Attributes:
        time: simulated [ns].
        key: of the topic or the query.
        content: the whole map; a message's header is part of it.
        asked: it is a query.
    """

    time: int
    key: str
    content: dict[str, Any]
    asked: bool = False


def save(path: Path, events: Sequence[Event]) -> None:
    """Write a recording; its floats are rounded."""
    names = list(dict.fromkeys((event.key, event.asked) for event in events))
    order = [{("time",): event.time, ("which",): names.index((event.key, event.asked))} for event in events]
    parts = []
    for key, asked in names:

        def decimals(place: Place, key: str = key) -> int:
            return _DECIMALS.get((key, str(place[0])), _USUAL)

        rows = [columns.leaves(event.content) for event in events if (event.key, event.asked) == (key, asked)]
        parts.append([key, asked, columns.pack(rows, decimals)])
    columns.write(path, [columns.pack(order, lambda place: None), parts])


def load(path: Path) -> list[Event]:
    """Read a recording."""
    order, parts = columns.read(path)
    queues = [(key, asked, iter(columns.unpack(packed))) for key, asked, packed in parts]
    events = []
    for row in columns.unpack(order):
        key, asked, rows = queues[row[("which",)]]
        events.append(Event(row[("time",)], key, columns.build(next(rows)), asked))
    return events
