"""What a drawing consists of, read back from the file that it went to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
from rerun.chunk import RrdReader

from services.viewer.draw.drawing import PERIOD, Drawing
from services.viewer.heard import Ears
from services.viewer.recorded import RecordedClock
from services.viewer.stream import Stream
from shared.clock import nanoseconds
from shared.messages import Header
from shared.schema.records import Record
from shared.topics import Topic
from shared.wire.codec import encode

CLEARED = "Clear:is_recursive"


class Drawn:
    """The rows of a file by entity and component, in their order: time [s], NaN for what is static, and value."""

    def __init__(self, path: Path) -> None:
        self.rows: dict[str, dict[str, list[tuple[float, Any]]]] = {}
        for chunk in RrdReader(path).stream().to_chunks():
            batch = chunk.to_record_batch()
            times = batch.column("time").cast("int64").to_pylist() if "time" in batch.schema.names else None
            for name in batch.schema.names:
                if ":" not in name:
                    continue
                rows = self.rows.setdefault(chunk.entity_path, {}).setdefault(name, [])
                values = batch.column(name).to_pylist()
                rows += [
                    (np.nan if times is None else times[i] * 1e-9, value)
                    for i, value in enumerate(values)
                    if value is not None
                ]
        for components in self.rows.values():
            for rows in components.values():
                rows.sort(key=lambda row: row[0])

    @property
    def entities(self) -> set[str]:
        """Of which something was drawn at some time."""
        return {path for path, parts in self.rows.items() if any(t == t for rows in parts.values() for t, _ in rows)}

    def of(self, path: str, component: str) -> list[tuple[float, Any]]:
        """All rows of an entity's component."""
        return self.rows.get(f"/{path}", {}).get(component, [])

    def last(self, path: str, component: str) -> Any:
        """The last value of an entity's component."""
        return self.of(path, component)[-1][1]

    def gone(self, path: str) -> bool:
        """Whether an entity was taken away after all that was drawn of it."""
        cleared = [time for time, _ in self.of(path, CLEARED)]
        drawn = [
            time
            for name, parts in self.rows.items()
            if name == f"/{path}" or name.startswith(f"/{path}/")
            for component, rows in parts.items()
            for time, _ in rows
            if component != CLEARED and time == time
        ]
        return bool(cleared and drawn) and max(cleared) >= max(drawn)


class Stage:
    """A drawing whose time is moved on by hand.

    Args:
        path: of the file that it goes to.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._clock, self._seq = RecordedClock(), 0
        self._stream = Stream.written(path)
        self.rec: rr.RecordingStream = self._stream.rec
        self.ears = Ears(self._clock, 0)
        self.drawing = Drawing(self.rec, self.ears)

    def say(self, topic: Topic, message: Record, session: int = 1) -> None:
        """Somebody publishes a message now."""
        self._seq += 1
        self.ears.hear(topic.key, encode(message, Header(self._seq, session, self._clock.now, True)))

    def run(self, duration: float, *said: tuple[Topic, Record]) -> None:
        """Let time [s] pass; these messages come all the while, at 100 Hz."""
        end = self._clock.now + nanoseconds(duration)
        due = self._clock.now
        while self._clock.now < end:
            for topic, message in said:
                self.say(topic, message)
            self._clock.now += nanoseconds(0.01)
            if self._clock.now - due >= nanoseconds(PERIOD):
                due = self._clock.now
                self.drawing.advance()

    def end(self) -> Drawn:
        """All that was drawn."""
        self.drawing.end()
        self._stream.__exit__(None, None, None)
        return Drawn(self._path)
