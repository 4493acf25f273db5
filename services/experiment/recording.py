"""What an experiment heard: every message of every topic as arrays over one clock, with the events of its protocol.

A message becomes one row. Nested messages become dotted fields (`bag.height`); a part that was absent in a message
(`bag: null`) is NaN there. Time is the steady clock's, in seconds, zero where the protocol's clock starts, so rows
from before the start (settling, taring) have negative times.
"""

from __future__ import annotations

import csv
import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

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
    that is itself called time becomes `message_time`).
    """

    meta: dict[str, Any]
    events: list[Event] = field(default_factory=list)
    topics: dict[str, Columns] = field(default_factory=dict)

    def time(self, key: str) -> np.ndarray:
        """Times (n,) [s] of a topic's messages; KeyError names a topic that was never heard."""
        return self._columns(key)["time"]

    def series(self, key: str, name: str) -> np.ndarray:
        """One field of a topic, (n,) or (n, k); KeyError names what is missing."""
        columns = self._columns(key)
        if name not in columns:
            raise KeyError(f"{key} has no field {name!r} in this recording; it has {', '.join(columns)}")
        return columns[name]

    def event(self, name: str) -> Event | None:
        """The first event of that name, or None."""
        return next((event for event in self.events if event.name == name), None)

    def _columns(self, key: str) -> Columns:
        if key not in self.topics:
            raise KeyError(f"{key} was not heard in this run; heard: {', '.join(self.topics) or 'nothing'}")
        return self.topics[key]

    def save(self, path: Path) -> None:
        """Writes everything to one compressed .npz file, which `load` reads back."""
        arrays = {
            f"{key}|{name}": values
            for key, columns in self.topics.items()
            for name, values in columns.items()
        }
        events = [dataclasses.asdict(event) for event in self.events]
        arrays["meta"] = np.array(json.dumps({"meta": self.meta, "events": events}))
        np.savez_compressed(path, allow_pickle=False, **arrays)

    @classmethod
    def load(cls, path: Path) -> Recording:
        """Reads a file written by `save`."""
        with np.load(path, allow_pickle=False) as archive:
            head = json.loads(str(archive["meta"]))
            topics: dict[str, Columns] = {}
            for entry in archive.files:
                if entry != "meta":
                    key, name = entry.split("|", 1)
                    topics.setdefault(key, {})[name] = archive[entry]
        return cls(head["meta"], [Event(**event) for event in head["events"]], topics)

    def write_csv(self, folder: Path) -> list[Path]:
        """One CSV file per topic and one of the events; vectors are spread as `force.0, force.1, ...`."""
        folder.mkdir(parents=True, exist_ok=True)
        written = []
        for key, columns in self.topics.items():
            path = folder / f"{key.replace('/', '_')}.csv"
            flat = {
                name: column for name, values in columns.items() for name, column in _spread(name, values)
            }
            with path.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file)
                writer.writerow(flat)
                writer.writerows(zip(*(column.tolist() for column in flat.values()), strict=True))
            written.append(path)
        path = folder / "events.csv"
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(("time", "event", "detail"))
            writer.writerows(dataclasses.astuple(event) for event in self.events)
        return [*written, path]


class Recorder:
    """Collects messages as they arrive; `finish` turns them into arrays. Its cost per message is one list append."""

    def __init__(self) -> None:
        """Starts empty."""
        self._rows: dict[str, list[tuple[float, Any]]] = {}

    def heard(self, key: str, time: float, message: Any) -> None:
        """Takes a message (a dataclass) that arrived at `time` [s]."""
        self._rows.setdefault(key, []).append((time, message))

    def finish(self, meta: dict[str, Any], events: list[Event], start: float) -> Recording:
        """Everything heard so far, with times and events counted from `start` [s]."""
        topics = {}
        for key, rows in sorted(self._rows.items()):
            rows = list(rows)
            columns = _columns([flatten(message) for _, message in rows])
            if "time" in columns:
                columns["message_time"] = columns.pop("time")
            topics[key] = {"time": np.array([time for time, _ in rows]) - start, **columns}
        shifted = [Event(event.time - start, event.name, event.detail) for event in events]
        return Recording(meta, shifted, topics)


def flatten(message: Any, prefix: str = "") -> dict[str, Any]:
    """The fields of a message as one flat mapping: nested messages dotted, free mappings as JSON, absent parts None."""
    flat: dict[str, Any] = {}
    for item in dataclasses.fields(message):
        value = getattr(message, item.name)
        name = prefix + item.name
        if dataclasses.is_dataclass(value):
            flat |= flatten(value, f"{name}.")
        elif isinstance(value, Mapping):
            flat[name] = json.dumps(value, default=_plain)
        elif not isinstance(value, bytes):  # images belong in no table
            flat[name] = value
    return flat


def _plain(value: Any) -> Any:
    return flatten(value) if dataclasses.is_dataclass(value) else np.asarray(value).tolist()


def _columns(rows: list[dict[str, Any]]) -> Columns:
    names = dict.fromkeys(name for row in rows for name in row)
    columns: Columns = {}
    for name in names:
        values = [row.get(name) for row in rows]
        sample = next((value for value in values if value is not None), None)
        if sample is None:
            continue
        absent: Any = "" if isinstance(sample, str) else np.full(np.shape(sample), np.nan)
        column = np.array([absent if value is None else value for value in values])
        # The joints' names repeat in every message; one row of them says it all.
        columns[name] = column[:1] if column.ndim == 2 and column.dtype.kind == "U" else column
    return columns


def _spread(name: str, values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if values.ndim == 2 and values.dtype.kind == "U":
        return []
    if values.ndim == 1:
        return [(name, values)]
    return [(f"{name}.{index}", values[:, index]) for index in range(values.shape[1])]
