"""Hypothesis strategies for every message of the contract, made from nothing but the kinds of its fields."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import strategies as st

from shared.messages import DISTORTION_SIZES, CameraImage, FtSample, Header, Health
from shared.requests import Setup
from shared.schema.fields import Anything, Boolean, Bytes, Direction, Integer, Kind, Number, Text, TextList, Vector
from shared.schema.records import MapOf, Nullable, Record, RecordOf
from shared.topics import TOPICS

MESSAGES: tuple[type[Record], ...] = (*dict.fromkeys(topic.message for topic in TOPICS), Health, Setup)

# Far beyond anything physical, and yet no vector's sum overflows; overflowing ones have tests of their own.
_LARGE = 1e300
_numbers = st.floats(-_LARGE, _LARGE) | st.floats(-10, 10)
_texts = st.text(st.characters(exclude_categories=("Cs",)), max_size=20)


def _number(kind: Number) -> st.SearchStrategy[float]:
    lowest = max(kind.above, kind.minimum)
    if lowest == -math.inf:
        return _numbers
    return st.floats(lowest, min(kind.maximum, _LARGE), exclude_min=kind.above == lowest)


def _direction(size: int) -> st.SearchStrategy[list[float]]:
    parts = st.lists(st.floats(-1, 1), min_size=size, max_size=size)
    return parts.filter(lambda q: math.hypot(*q) > 1e-3).map(lambda q: [x / math.hypot(*q) for x in q])


def value(kind: Kind, length: int = 3) -> st.SearchStrategy[Any]:
    """A plain value, as MessagePack carries it, that the contract admits for a field of this kind."""
    match kind:
        case Direction(size=int(size)):
            return _direction(size)
        case Vector():
            size = kind.size if kind.size is not None else length
            lowest = max(kind.above, kind.minimum, -_LARGE)
            element = st.floats(lowest, _LARGE, exclude_min=kind.above == lowest)
            return st.lists(element, min_size=size, max_size=size)
        case Number():
            return _number(kind)
        case Integer():
            return st.integers(kind.minimum, 2**64 - 1)
        case Boolean():
            return st.booleans()
        case Text():
            return st.sampled_from(kind.choices) if kind.choices else _texts
        case TextList():
            return st.lists(_texts, min_size=length, max_size=length)
        case Bytes():
            return st.binary(max_size=200)
        case Anything():
            return _numbers | st.booleans() | _texts
        case RecordOf():
            assert kind.record is not None
            return plain(kind.record)
        case Nullable():
            return st.none() | value(kind.kind, length)
        case MapOf():
            return st.dictionaries(_texts, value(kind.kind), max_size=3)
    raise AssertionError(f"no strategy for {type(kind).__name__}")


def _downwards(direction: list[float]) -> list[float]:
    return direction if direction[2] <= -0.5 else [0.0, 0.0, -1.0]


def plain(message: type[Record]) -> st.SearchStrategy[dict[str, Any]]:
    """Every field of a message, as plain values."""
    if message is FtSample:
        return _fields(message, 3).map(lambda fields: fields | {"gravity": _downwards(fields["gravity"])})
    lengths = st.sampled_from(DISTORTION_SIZES) if message is CameraImage else st.integers(0, 5)
    return lengths.flatmap(lambda length: _fields(message, length))


def _fields(message: type[Record], length: int) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries({name: value(kind, length) for name, kind, _ in message.kinds()})


def payload_map(message: type[Record]) -> st.SearchStrategy[dict[str, Any]]:
    """Header and fields side by side, as they travel."""
    return st.tuples(plain(Header), plain(message)).map(lambda parts: parts[0] | parts[1])


any_plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(st.characters(exclude_categories=("Cs",)), max_size=8)
    | st.binary(max_size=8),
    lambda inner: st.lists(inner, max_size=7) | st.dictionaries(_texts, inner, max_size=4),
    max_leaves=20,
)
"""Anything that MessagePack can carry."""
