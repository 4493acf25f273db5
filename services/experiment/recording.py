"""What an experiment heard: every message of every topic as arrays over one clock, with the events of its protocol.

A message becomes one row. Nested messages become dotted fields (`bag.height`); a part that was absent in a message
(`bag: null`) is NaN there. Time is the steady clock's, in seconds, zero where the protocol's clock starts, so rows
from before the start (settling, taring) have negative times.
"""

from __future__ import annotations

import csv
import dataclasses
import json
from dataclasses import MISSING, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from shared.codec import Rejected, decode, decode_map
from shared.topics import Topic, topic_by_key

RECORDING = "recording.npz"  # its name in the folder of a run
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
    """Keeps payloads as they arrive, at the cost of one list append each; `finish` turns them into arrays."""

    def __init__(self) -> None:
        """Starts empty."""
        self._heard: dict[str, list[tuple[float, bytes]]] = {}

    def heard(self, topic: Topic, time: float, payload: bytes) -> None:
        """Takes a payload of a topic that arrived at `time` [s]."""
        self._heard.setdefault(topic.key, []).append((time, payload))

    def finish(self, meta: dict[str, Any], events: list[Event], start: float) -> Recording:
        """Everything heard so far, with times and events counted from `start` [s].

        What is no message of its topic is left out and counted in `meta["rejected"]`.
        """
        topics: dict[str, Columns] = {}
        rejected: dict[str, int] = {}
        for key, heard in sorted((key, list(heard)) for key, heard in self._heard.items()):
            topic = topic_by_key(key)
            assert topic is not None
            try:
                columns = _table(topic, heard, start)
            except (ValueError, TypeError):
                # Some value has another shape than its column: only now is the full check of each message worth it.
                columns = _table(
                    topic, [(time, payload) for time, payload in heard if _sound(topic, payload)], start
                )
            if len(columns["time"]) < len(heard):
                rejected[key] = len(heard) - len(columns["time"])
            topics[key] = columns
        shifted = [Event(event.time - start, event.name, event.detail) for event in events]
        return Recording(meta | {"rejected": rejected}, shifted, topics)


def _row(topic: Topic, payload: bytes) -> dict[str, Any] | None:
    """The fields of one message as one flat mapping, or None if it is no message of the topic.

    Images and other bytes are left out. The full check of every element is the readers' in the control loop; here the
    shapes decide, since a column has one.
    """
    try:
        data = decode_map(payload, topic.cap)
    except Rejected:
        return None
    fields = {"valid": data.get("valid", MISSING)}
    fields |= {name: data.get(name, default) for name, _, default in topic.message.kinds()}
    if any(value is MISSING for value in fields.values()):
        return None
    return _flatten({name: value for name, value in fields.items() if not isinstance(value, bytes)})


def _sound(topic: Topic, payload: bytes) -> bool:
    try:
        decode(topic.message, payload, topic.cap)
    except Rejected:
        return False
    return True


def _flatten(data: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested messages dotted; maps with free keys (an input's key has a slash) as JSON; absent parts None."""
    flat: dict[str, Any] = {}
    for name, value in data.items():
        if not isinstance(value, dict):
            flat[prefix + name] = value
        elif any("/" in key for key in value) or not value:
            flat[prefix + name] = json.dumps(value)
        else:
            flat |= _flatten(value, f"{prefix}{name}.")
    return flat


def _table(topic: Topic, heard: list[tuple[float, bytes]], start: float) -> Columns:
    rows = [(time, flat) for time, payload in heard if (flat := _row(topic, payload)) is not None]
    columns = _columns([flat for _, flat in rows])
    if "time" in columns:
        columns["message_time"] = columns.pop("time")
    return {"time": np.array([time for time, _ in rows]) - start, **columns}


def _columns(rows: list[dict[str, Any]]) -> Columns:
    columns: Columns = {}
    for name in dict.fromkeys(name for row in rows for name in row):
        values = [row.get(name) for row in rows]
        sample = next((value for value in values if value is not None), None)
        if sample is None:
            continue
        if isinstance(sample, list) and sample and isinstance(sample[0], str):
            columns[name] = np.array(
                [sample]
            )  # the joints' names repeat in every message; one row says it all
            continue
        absent: Any = "" if isinstance(sample, str) else np.full(np.shape(sample), np.nan)
        columns[name] = np.array([absent if value is None else value for value in values])
    return columns


def _spread(name: str, values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if values.ndim == 2 and values.dtype.kind == "U":
        return []
    if values.ndim == 1:
        return [(name, values)]
    return [(f"{name}.{index}", values[:, index]) for index in range(values.shape[1])]
