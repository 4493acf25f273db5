"""Writes docs/contract.md, the reference of the Zenoh interface, from the table of topics."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import MISSING
from typing import Any

import numpy as np

from shared.messages import Header
from shared.schema.fields import Anything, Boolean, Bytes, Integer, Kind, Number, Quaternion, Text, TextList, Vector
from shared.schema.records import MapOf, Nullable, Record, RecordOf
from shared.topics import ANYBODY, QUERIES, ROBOT, ROS_ROBOT, TOPICS, own_topics

_PREAMBLE = """\
# The Zenoh interface, version 1

Generated from `shared/topics.py` by `python -m shared.reference`; `make test` fails when it is out of date.

- Keys are `<robot>/<key>`; `<robot>` is one chunk, `tiago` by default.
- A payload is one MessagePack map with text keys, Zenoh encoding `application/msgpack`. Unknown fields are ignored. A
  missing field (unless it says what holds if absent), a wrong type or shape, a number that is not finite or out of
  bounds, or a payload over the cap rejects the message: it is counted, never used, and crashes nothing.
- SI units. Quaternions are `[x, y, z, w]` of unit norm. Unless a field says otherwise it is in the axes of `base`, the
  robot's `base_footprint`; `tool` is the grasping frame of the right gripper, `sensor` the wrist's force-torque frame.
- A twist is the linear velocity of the tool's origin and the angular velocity, relative to `base`. A wrench is what the
  environment exerts on the robot: a mass of 1 kg that hangs from the tool gives force z = -9.81 N.
- Every subscription is latest-value. Nobody may queue control data.
- A running service holds the liveliness tokens `<robot>/alive/<service>` and `<robot>/alive/<service>/<session>`, the
  session of its headers. One of a kind at a time: a second one ends with status 3.
"""

_TYPES: tuple[tuple[type[Kind], str], ...] = (
    (Quaternion, "quaternion"),
    (Number, "float"),
    (Integer, "int"),
    (Boolean, "bool"),
    (TextList, "text list"),
    (Text, "text"),
    (Bytes, "bytes"),
    (Anything, "anything"),
)


_LEAST = Integer().minimum
"""Below every bound that is worth a word."""


def _type_name(kind: Kind) -> str:
    if isinstance(kind, RecordOf):
        return "map"
    if isinstance(kind, MapOf):
        return "map" if isinstance(kind.kind, Anything) else f"map of {_type_name(kind.kind)}s"
    if isinstance(kind, Nullable):
        return f"{_type_name(kind.kind)} or null"
    for cls, name in _TYPES:
        if isinstance(kind, cls):
            choices = kind.choices if isinstance(kind, Text) else ()
            return " / ".join(f'"{choice}"' for choice in choices) or name
    assert isinstance(kind, Vector)
    return f"float[{kind.size or 'n'}]"


def _range(kind: Kind) -> str:
    if isinstance(kind, Nullable):
        return _range(kind.kind)
    parts = []
    if isinstance(kind, (Number, Vector)) and kind.above > -math.inf:
        parts.append(f"> {kind.above:g}")
    elif isinstance(kind, (Number, Vector, Integer)) and kind.minimum > _LEAST:
        parts.append(f">= {kind.minimum:g}")
    if isinstance(kind, (Number, Vector)) and kind.maximum < math.inf:
        parts.append(f"<= {kind.maximum:g}")
    return ", ".join(parts)


def _absent(default: Any) -> str:
    if default is MISSING:
        return ""
    if isinstance(default, np.ndarray):
        return f"[{', '.join(f'{number:g}' for number in default)}] if absent"
    # As MessagePack has it: null, not None.
    return f"{json.dumps(default) if default != '' else 'empty'} if absent"


def _fields(record: type[Record], indent: str = "") -> Iterator[str]:
    for name, kind, default in record.kinds():
        about = ", ".join(part for part in (kind.unit, _range(kind), kind.doc, _absent(default)) if part)
        yield f"{indent}- `{name}` {_type_name(kind)}{': ' + about if about else ''}"
        inner = kind.kind if isinstance(kind, (MapOf, Nullable)) else kind
        if isinstance(inner, RecordOf) and inner.record is not None:
            yield from _fields(inner.record, indent + "  ")


def _who(names: tuple[str, ...]) -> str:
    """Publishers or servers, in words."""
    known = {
        ROBOT: "robot (simulation or bridge)",
        ROS_ROBOT: "a simulated robot behind a bridge",
        ANYBODY: "anybody permitted",
    }
    return " or ".join(known.get(name, name) for name in names)


def lines() -> Iterator[str]:
    """The lines of the reference."""
    yield _PREAMBLE
    yield "## Header of every message\n"
    yield from _fields(Header)
    yield "\n## Topics\n"
    yield "| key | message | nominal rate | used up to an age of | publisher | cap |"
    yield "|---|---|---|---|---|---|"
    topics = (*TOPICS, *own_topics("<service>"))
    for topic in topics:
        rate = f"{topic.rate:g} Hz" if topic.rate else "on change"
        age = "until replaced" if topic.max_age == float("inf") else f"{topic.max_age:g} s"
        publisher = _who(topic.publishers)
        yield f"| `{topic.key}` | {topic.message.__name__} | {rate} | {age} | {publisher} | {topic.cap // 1024} KiB |"
    yield "\n## Messages"
    for topic in topics:
        yield f"\n### {topic.message.__name__} (`{topic.key}`)\n"
        yield f"{topic.message.__doc__}\n"
        yield from _fields(topic.message)
    yield "\n## Queries"
    yield '\nRequest and reply are maps, the reply with `ok` besides; a refusal is `{"ok": false, "error": text}`.'
    for query in QUERIES:
        yield f"\n### `{query.key}`, answered by {_who(query.servers)}"
        for word, (request, reply) in query.exchanges.items():
            which = f'`{query.word}` "{word}": ' if word else ""
            yield f"\n{which}{request.__doc__}\n"
            yield from _fields(request)
            if reply.kinds():
                yield f"- reply: {reply.__doc__}"
                yield from _fields(reply, "  ")


if __name__ == "__main__":
    print("\n".join(lines()))
