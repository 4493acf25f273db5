"""What an experiment heard: every message of every topic as arrays over one clock, with the events of its protocol.

A message becomes one row. Nested messages become dotted fields (`bag.height`); a part that was absent in a message
(`bag: null`) is NaN there. Time is the steady clock's, in seconds, zero where the protocol's clock starts, so rows
from before the start (settling, taring) have negative times.
"""

from __future__ import annotations

import csv
import dataclasses
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from shared.clock import seconds
from shared.requests import Setup
from shared.topics import SENSOR_CAMERA, Topic, topic_by_key
from shared.wire.codec import Rejected, decode
from shared.wire.log import ABOUT, Heard, Log, NoRecording

RECORDING = "recording.mcap"  # its name in the folder of a run
RUN, END = "run", "end"
"""What a run's player says of it at the beginning, and when it has been played."""
Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class Event:
    """Something that the protocol did or saw, at `time` [s] of the experiment's clock."""

    time: float
    name: str
    detail: str = ""


@dataclass
class Recording:
    """All series of one run.

    `meta` describes the run (name, law, limits, settings; JSON types only). `topics` maps a key without the robot's
    prefix to its columns: `time` (n,) [s] and one array (n,) or (n, k) per field, units as in the message (a field
    that is itself called time becomes `message_time`). Time zero is `zero` [s] of the player's clock.
    """

    meta: dict[str, Any]
    events: list[Event] = field(default_factory=list)
    topics: dict[str, Columns] = field(default_factory=dict)
    zero: float = 0.0

    def time(self, key: str) -> np.ndarray:
        """Times (n,) [s] of a topic's messages; KeyError names a topic that was never heard."""
        return self._columns(key)["time"]

    def series(self, key: str, name: str) -> np.ndarray:
        """One field of a topic, (n,) or (n, k); KeyError names what is missing."""
        columns = self._columns(key)
        if name not in columns:
            raise KeyError(f"{key} has no field {name!r} in this recording; it has {', '.join(columns)}")
        return columns[name]

    def newest(self, key: str, time: np.ndarray, *names: str) -> np.ndarray:
        """Fields of a topic's newest message at each time (n,) [s], side by side; of its first one before that."""
        rows = np.maximum(np.searchsorted(self.time(key), time, side="right") - 1, 0)
        fields = [self.series(key, name)[rows] for name in names]
        return fields[0] if len(fields) == 1 else np.column_stack(fields)

    def event(self, name: str) -> Event | None:
        """The first event of that name, or None."""
        return next((event for event in self.events if event.name == name), None)

    def _columns(self, key: str) -> Columns:
        if key not in self.topics:
            raise KeyError(f"{key} was not heard in this run; heard: {', '.join(self.topics) or 'nothing'}")
        return self.topics[key]

    @classmethod
    def of(cls, about: Mapping[str, Any], heard: Iterable[Heard], end: Mapping[str, Any]) -> Recording:
        """What was heard, as arrays; what is no message of its topic is left out and counted in `meta["rejected"]`.

        Args:
            about: what the run was, as its player says at the beginning.
            heard: in the order of arrival.
            end: what its player says at the end: `start` [s], events.
        """
        start = end["start"]
        found: dict[str, list[tuple[float, dict[str, Any]]]] = {}
        rejected: dict[str, int] = {}
        for key, arrival, payload in heard:
            topic = topic_by_key(key)
            # Pictures are no series, and neither is what a service works by.
            if topic is None or topic is SENSOR_CAMERA or topic.message is Setup:
                continue
            plain = _plain(topic, payload)
            if plain is None:
                rejected[key] = rejected.get(key, 0) + 1
            else:
                found.setdefault(key, []).append((seconds(arrival) - start, plain))
        topics: dict[str, Columns] = {}
        for key, rows in sorted(found.items()):
            topics[key] = {"time": np.array([time for time, _ in rows])}
            for name in rows[0][1]:
                column = "message_time" if name == "time" else name
                topics[key] |= _columns(column, [plain[name] for _, plain in rows])
        events = [Event(time - start, name, detail) for time, name, detail in end["events"]]
        return cls({**about, "rejected": rejected}, events, topics, start)

    @classmethod
    def load(cls, path: Path) -> Recording:
        """Reads the recording of a run.

        Raises:
            FileNotFoundError: there is none.
            ValueError: it is damaged, no recording, or of a run that was not played to its end.
        """
        try:
            log = Log(path)
            heard = list(log)
        except NoRecording as problem:
            raise ValueError(f"{problem}: play the run again") from None
        if not {RUN, END} <= log.about.keys():
            raise ValueError(f"{path}: the run was not played to its end: play it again")
        return cls.of({**log.about[ABOUT], **log.about[RUN]}, heard, log.about[END])

    def write_csv(self, folder: Path) -> list[Path]:
        """One CSV file per topic and one of the events; vectors are spread as `force.0, force.1, ...`."""
        folder.mkdir(parents=True, exist_ok=True)
        written = []
        for key, columns in self.topics.items():
            flat = {name: column.tolist() for name, values in columns.items() for name, column in _spread(name, values)}
            written.append(_write(folder / f"{key.replace('/', '_')}.csv", flat, zip(*flat.values(), strict=True)))
        events = (dataclasses.astuple(event) for event in self.events)
        return [*written, _write(folder / "events.csv", ("time", "event", "detail"), events)]


def told(path: Path) -> dict[str, Any]:
    """What the player of a recorded run says of it at the beginning; FileNotFoundError and ValueError as `load`."""
    log = Log(path)
    next((None for _ in log if RUN in log.about), None)
    return log.about.get(RUN, {})


def _plain(topic: Topic, payload: bytes) -> dict[str, Any] | None:
    """A message of a topic as a map, with `valid` of its header; None if it is none."""
    try:
        header, message = decode(topic.message, payload, topic.cap)
    except Rejected:
        return None
    return {"valid": header.valid, **message.to_plain()}


def _columns(name: str, values: list[Any]) -> Columns:
    """The columns of one field, given its value in every message; images and other bytes have none."""
    kinds = set(map(type, values))
    columns: Columns = {}
    if dict in kinds:
        nested = [value if isinstance(value, dict) and not _has_free_keys(value) else {} for value in values]
        for part in dict.fromkeys(part for value in nested for part in value):
            columns |= _columns(f"{name}.{part}", [value.get(part) for value in nested])
        values = [_as_text(value) if isinstance(value, dict) else value for value in values]
    if not kinds.isdisjoint((dict, bytes, NoneType)):
        values = [None if isinstance(value, bytes) else value for value in values]
        sample = next((value for value in values if value is not None), None)
        if sample is None:
            return columns
        absent: Any = "" if isinstance(sample, str) else np.full(np.shape(sample), np.nan)
        values = [absent if value is None else value for value in values]
    if values and isinstance(values[0], tuple) and values[0] and isinstance(values[0][0], str):
        values = values[:1]  # the joints' names repeat in every message; one row says it all
    return columns | {name: np.array(values)}


def _has_free_keys(value: dict[str, Any]) -> bool:
    """Whether it is a map from anything, such as an input's key, which has a slash, and no nested message."""
    return not value or any("/" in key for key in value)


def _as_text(value: dict[str, Any]) -> str | None:
    return json.dumps(value) if _has_free_keys(value) else None


def _spread(name: str, values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if values.ndim == 2 and values.dtype.kind == "U":
        return []
    if values.ndim == 1:
        return [(name, values)]
    return [(f"{name}.{index}", values[:, index]) for index in range(values.shape[1])]


def _write(path: Path, head: Iterable[str], rows: Iterable[tuple[Any, ...]]) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)
    return path
