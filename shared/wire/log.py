"""Recordings: payloads as they were heard, in MCAP, one file or a row of files of bounded size.

What is written is what was on the bus, byte by byte, with its arrival; each channel has the contract's description of
its messages. A writer that is killed leaves a file that lacks at most the last part of a second.
"""

from __future__ import annotations

import json
import re
import struct
import threading
import time
from collections import deque
from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from shared.messages import Header
from shared.schema.json_schema import json_schema
from shared.schema.valid_json import valid_json
from shared.topics import topic_by_key

SUFFIX = ".mcap"
_WAITING = 20_000
"""Payloads that may wait to be written, some seconds' worth; what comes beyond is counted and lost, not waited for."""
_SLICE = 0.05  # [s] of messages that are written at a time: a thread that each one wakes costs more than the writing
_PART = 0.25  # [s] after which what was heard is on the disk
_CHUNK = 1 << 20  # [bytes] of messages that are packed together at most
_FILES = 8
"""Files that a bounded recording consists of: the oldest goes when another one is begun."""
ABOUT = "about"
"""Name of what the beginning of each file says of the recording."""
_NUMBER = re.compile(r"-\d{4}$")
"""What the name of one of several files of a recording ends with."""
_LARGEST = 1 << 28  # [bytes] of a chunk: what says more is no recording


class Heard(NamedTuple):
    """A payload under a key, and the reader's steady clock [ns] when it arrived."""

    key: str
    arrival_ns: int
    payload: bytes


class NoRecording(ValueError):
    """A file is no recording; the text is one line for the user."""


class LogWriter:
    """Writes what it is given, in a thread of its own, until ``close``.

    Args:
        path: of the file; of a bounded recording the files are numbered, ``NAME-0001.mcap`` and so on.
        about: what is to be said of the recording, in each file; JSON types.
        most: bytes on the disk that a bounded recording takes, about; 0 for one file without a bound.

    Attributes:
        heard: payloads that were given.
        lost: of those, that had to be left out since the disk was too slow, or ``problem`` came up.
        written: bytes on the disk.
        problem: why nothing is written any more, such as a full disk; empty if all is well.

    Raises:
        OSError: the file is there already, or cannot be written.
    """

    def __init__(self, path: Path, about: Mapping[str, Any], most: int = 0) -> None:
        self._path, self._most = path, most
        # Readers of MCAP want a time of day; it counts on evenly, since what was heard is timed by the steady clock.
        self._wall = time.time_ns() - time.monotonic_ns()
        self._about = {**about, "wall_ns": self._wall}
        self._waiting: deque[Heard | tuple[str, Mapping[str, Any]]] = deque()
        self._ended = threading.Event()
        self.heard = self.lost = self.written = 0
        self.problem = ""
        self._old: list[Path] = []
        self._file = self._next(1)
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._thread.start()

    def take(self, key: str, arrival_ns: int, payload: bytes) -> None:
        """Have a payload written; from any thread, and never waiting."""
        self.heard += 1
        if len(self._waiting) < _WAITING:
            # As mere bytes: what a payload was encoded from takes several times its memory.
            self._waiting.append(Heard(key, arrival_ns, bytes(payload)))
        else:
            self.lost += 1

    def note(self, name: str, content: Mapping[str, Any]) -> None:
        """Have something said of the recording so far, under a name; JSON types."""
        self._waiting.append((name, content))

    def close(self) -> None:
        """Write what is waiting and end the file."""
        self._ended.set()
        self._thread.join()

    def _next(self, number: int) -> _File:
        path = self._path.with_stem(f"{self._path.stem}-{number:04d}") if self._most else self._path
        return _File(path, number, self._about)

    def _run(self) -> None:
        flushed, ended = time.monotonic(), False
        while self._waiting or not ended:
            ended = self._ended.wait(_SLICE)
            with self._noted():
                for _ in range(len(self._waiting)):
                    self._write(self._waiting.popleft())
            if time.monotonic() - flushed > _PART and not self.problem:
                flushed = time.monotonic()
                with self._noted():
                    self._flush()
        with self._noted():
            self._file.end()

    @contextmanager
    def _noted(self) -> Iterator[None]:
        """What the disk refuses is the problem from then on; the first counts."""
        try:
            yield
        except OSError as problem:
            self.problem = self.problem or f"{self._file.path}: {problem.strerror or problem}"

    def _write(self, entry: Heard | tuple[str, Mapping[str, Any]]) -> None:
        if self.problem:
            self.lost += isinstance(entry, Heard)
        elif isinstance(entry, Heard):
            self._file.add(entry, self._wall)
        else:
            self._file.say(*entry)

    def _flush(self) -> None:
        self._file.flush()
        if self._most and self._file.size > self._most / _FILES:
            self._file.end()
            self._old.append(self._file.path)
            self._file = self._next(self._file.number + 1)
            while len(self._old) >= _FILES:
                self._old.pop(0).unlink(missing_ok=True)
        self.written = self._file.size + sum(path.stat().st_size for path in self._old)


class _File:
    """One file in the making.

    Attributes:
        path, number: of it.
        size: bytes on the disk.
    """

    def __init__(self, path: Path, number: int, about: Mapping[str, Any]) -> None:
        # Who knows of recordings and makes none, as the settings of a run do, needs no library for it.
        from mcap.writer import Writer

        self.path, self.number, self.size = path, number, 0
        self._stream = path.open("xb")
        self._writer = Writer(self._stream, chunk_size=_CHUNK)
        self._writer.start("tandem", "tandem")
        self._channels: dict[str, int] = {}
        self.say(ABOUT, about)

    def say(self, name: str, content: Mapping[str, Any]) -> None:
        self._writer.add_metadata(name, {"json": valid_json(content)})

    def add(self, heard: Heard, wall: int) -> None:
        channel = self._channels.get(heard.key) or self._channel(heard.key)
        when = heard.arrival_ns + wall
        self._writer.add_message(channel, log_time=when, publish_time=when, data=heard.payload)

    def _channel(self, key: str) -> int:
        topic, schema = topic_by_key(key), 0
        if topic is not None:
            described = json.dumps(json_schema(topic.message, beside=Header)).encode()
            schema = self._writer.register_schema(topic.message.__name__, "jsonschema", described)
        self._channels[key] = channel = self._writer.register_channel(key, "msgpack", schema)
        return channel

    def flush(self) -> None:
        """What was added so far is on the disk, and readable."""
        self._writer.flush()
        self._stream.flush()
        self.size = self._stream.tell()

    def end(self) -> None:
        self._writer.finish()
        self._stream.close()
        self.size = self.path.stat().st_size


def write_log(path: Path, about: Mapping[str, Any], heard: Iterable[Heard], **notes: Mapping[str, Any]) -> None:
    """Write a whole recording at once, where nobody waits for the disk.

    Its times of day begin in 1970, unless ``about`` says with the `wall_ns` of another recording when that was.
    """
    path.unlink(missing_ok=True)
    file = _File(path, 1, {"wall_ns": 0, **about})
    for one in heard:
        file.add(one, about.get("wall_ns", 0))
    for name, content in notes.items():
        file.say(name, content)
    file.end()


class Log:
    """A recording, read in one pass, as far as it goes: one whose writer was killed ends with its last whole part.

    Iterating gives what was heard in the order in which it was written.

    Attributes:
        about: by name what is said of the recording, of what has been passed so far.

    Args:
        path: of the file.
        keys: those to give; all if left out.

    Raises:
        NoRecording: it is none.
        OSError: it cannot be read.
    """

    def __init__(self, path: Path, keys: Container[str] | None = None) -> None:
        self.about: dict[str, dict[str, Any]] = {}
        self._path, self._keys = path, keys
        self._records = self._read()
        # What the file begins with.
        self._first = next(self._records, None)
        if ABOUT not in self.about:
            raise NoRecording(f"{path}: no recording of tandem's")

    def __iter__(self) -> Iterator[Heard]:
        if self._first is not None:
            yield self._first
        yield from self._records

    def _read(self) -> Iterator[Heard]:
        from mcap.exceptions import McapError
        from mcap.records import Channel, Message, Metadata
        from mcap.stream_reader import StreamReader
        from zstandard import ZstdError

        # What is damaged may say any length: the last two come of reading as many bytes.
        unreadable = McapError, KeyError, ValueError, TypeError, struct.error, ZstdError, MemoryError, OverflowError
        wall = 0
        channels: dict[int, str] = {}
        with self._path.open("rb") as stream:
            try:
                for record in StreamReader(stream, record_size_limit=_LARGEST).records:
                    match record:
                        case Message() if self._keys is None or channels[record.channel_id] in self._keys:
                            yield Heard(channels[record.channel_id], record.log_time - wall, record.data)
                        case Channel():
                            channels[record.id] = record.topic
                        case Metadata():
                            self.about[record.name] = json.loads(record.metadata["json"])
                            wall = self.about[ABOUT]["wall_ns"]
            except unreadable as problem:
                # Its writer was killed in the middle of a record.
                if not stream.read(1):
                    return
                raise NoRecording(f"{self._path}: damaged, or no recording ({type(problem).__name__})") from None


def recordings(place: Path) -> list[list[Path]]:
    """The recordings at a place, a file or a folder: each is a file, or the numbered files of a bounded one in order.

    Raises:
        NoRecording: there is none.
    """
    if place.is_file():
        return [[place]]
    found: dict[Path, list[Path]] = {}
    for path in sorted(place.glob(f"**/*{SUFFIX}")):
        found.setdefault(path.with_stem(_NUMBER.sub("", path.stem)), []).append(path)
    if not found:
        raise NoRecording(f"{place}: no recording (*{SUFFIX}) in it" if place.is_dir() else f"{place}: not there")
    return list(found.values())
