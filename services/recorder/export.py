"""A recording as programs show it that know nothing of this project: Foxglove, and rerun what it knows of the same.

Every message of the contract becomes JSON under its key, described by a JSON Schema, so that each number can be
plotted; what Foxglove has a type for is there as that too. Bytes are left out of the JSON; a number that is not finite
would be null, since JSON has no other word for it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema
from numpy import ndarray

from services.recorder.foxglove import Newest, show
from shared.messages import Header
from shared.robot.tiago import URDF
from shared.schema.fields import Bytes
from shared.schema.json_schema import json_schema
from shared.schema.records import Record
from shared.schema.valid_json import valid_json
from shared.topics import Topic, topic_by_key
from shared.wire.codec import Rejected, decode
from shared.wire.log import ABOUT, Log

_json = msgspec.json.Encoder(enc_hook=ndarray.tolist)


@dataclass
class Exported:
    """What was written.

    Attributes:
        messages: as JSON.
        shown: messages of Foxglove's.
        rejected: payloads that are no messages of the contract; they are left out.
    """

    messages: int = 0
    shown: int = 0
    rejected: dict[str, int] = field(default_factory=dict)


def export(paths: Sequence[Path], out: Path) -> Exported:
    """Write the files of a recording as one for Foxglove.

    Raises:
        shared.wire.log.NoRecording: a file is none.
        OSError: a file cannot be read, or written; one that is there is not written over.

    Whatever ends it early, an interruption too, ends its file.
    """
    logs = [Log(path) for path in paths]
    with out.open("xb") as stream:
        try:
            return _exported(logs, stream)
        except BaseException:  # who interrupts it is left with nothing that looks like a whole recording
            out.unlink()
            raise


def _exported(logs: Sequence[Log], stream: BinaryIO) -> Exported:
    file = _File(stream)
    for log in logs:
        for one in log:
            file.add(one.key, one.arrival_ns + log.about[ABOUT]["wall_ns"], one.payload)
    for name, content in {name: content for log in logs for name, content in log.about.items()}.items():
        file.writer.add_metadata(name, {"json": valid_json(content)})
    file.writer.finish()
    return file.exported


class _File:
    """One in the making."""

    def __init__(self, stream: BinaryIO) -> None:
        self.writer = Writer(stream)
        self.writer.start("", "tandem")
        # Who is shown the robot needs its description.
        self.writer.add_attachment(0, 0, URDF.name, "application/xml", URDF.read_bytes())
        self.exported = Exported()
        self._newest: Newest = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def add(self, key: str, time: int, payload: bytes) -> None:
        topic = topic_by_key(key)
        if topic is None:
            self._reject(key)
            return
        try:
            header, message = decode(topic.message, payload, topic.cap)
        except Rejected:
            self._reject(key)
            return
        self.exported.messages += 1
        self._write(self._channels.get(key) or self._described(topic), time, _as_json(header, message))
        for name, shown in show(key, message, time, self._newest):
            self.exported.shown += 1
            self._write(self._channels.get(name) or self._typed(name, shown), time, shown.SerializeToString())

    def _reject(self, key: str) -> None:
        self.exported.rejected[key] = self.exported.rejected.get(key, 0) + 1

    def _write(self, channel: int, time: int, data: bytes) -> None:
        self.writer.add_message(channel, log_time=time, publish_time=time, data=data)

    def _described(self, topic: Topic) -> int:
        described = json_schema(topic.message, beside=Header)
        for name in _bytes_of(topic.message):
            del described["properties"][name]
            described["required"] = [one for one in described["required"] if one != name]
        schema = self.writer.register_schema(
            f"tandem.{topic.message.__name__}", "jsonschema", json.dumps(described).encode()
        )
        self._channels[topic.key] = channel = self.writer.register_channel(topic.key, "json", schema)
        return channel

    def _typed(self, name: str, message: Any) -> int:
        kind = message.DESCRIPTOR.full_name
        if kind not in self._schemas:
            self._schemas[kind] = register_schema(self.writer, type(message))
        self._channels[name] = channel = self.writer.register_channel(name, "protobuf", self._schemas[kind])
        return channel


def _bytes_of(message: type[Record]) -> list[str]:
    return [name for name, kind, _ in message.kinds() if isinstance(kind, Bytes)]


def _as_json(header: Header, message: Record) -> bytes:
    """Header and message as one object."""
    if hidden := _bytes_of(type(message)):
        plain = {name: value for name, value in message.to_plain().items() if name not in hidden}
        return _json.encode(header)[:-1] + b"," + _json.encode(plain)[1:]
    return _json.encode(header)[:-1] + b"," + _json.encode(message)[1:]
