"""What a service would have done otherwise: figures of its recorded answers beside those of a replay with changes.

A replay is an open loop: its inputs are what the robot felt then, whatever is answered now.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from services.experiment.replay.equality import MEASURED, Difference
from services.experiment.replay.recorded import Answers, Said
from shared.clock import seconds
from shared.messages import ControlTarget
from shared.schema.fields import Number, Text, Vector
from shared.schema.records import Record
from shared.spatial import Array
from shared.topics import CONTROL_STATUS, CONTROL_TARGET, Topic, topic_by_key
from shared.wire.codec import Rejected, decode, encode

OPEN_LOOP = "open loop: the inputs are those of then, and do not react to what is answered now"
AXES = ("force x", "force y", "force z", "torque x", "torque y", "torque z")
_ANY_LIMIT = {"force_limit": np.ones(3), "torque_limit": np.ones(3)}
_LASTS = 0.2  # [s] that an answer holds at most, if no other one follows
_REASONS = 6  # texts that are told at most, those that held longest


@dataclass(frozen=True)
class Figure:
    """A figure before and after; NaN where it has no value."""

    name: str
    unit: str
    recorded: float
    replayed: float


@dataclass(frozen=True)
class _Series:
    """Messages of one key, when they were said [s], and how long each of them held [s]."""

    messages: list[Any]
    times: Array
    lasted: Array

    def of(self, field: str) -> Array:
        return np.array([getattr(message, field) for message in self.messages])


def limited(limits: Mapping[str, Array]) -> Callable[[str, bytes], bytes]:
    """Gives each target of the controller other limits.

    Args:
        limits: `force_limit` [N], `torque_limit` [Nm], three numbers each, or one of both.

    Raises:
        shared.schema.fields.InvalidField: no target may have such limits.
    """
    ControlTarget(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), **{**_ANY_LIMIT, **limits})

    def edit(key: str, payload: bytes) -> bytes:
        if key != CONTROL_TARGET.key:
            return payload
        try:
            header, target = decode(ControlTarget, payload)
        except Rejected:
            return payload
        return encode(target.replaced(**limits), header)

    return edit


def first_difference(recorded: Answers, replayed: Answers) -> Difference | None:
    """Where the answers first differ in a number or a text; None if nowhere."""
    start = min((stamp for said in recorded.values() for stamp in said), default=0)
    both = sorted((stamp, key) for key in recorded for stamp in recorded[key].keys() & replayed.get(key, {}).keys())
    for stamp, key in both:
        one, other = (_message(key, answers[key][stamp]) for answers in (recorded, replayed))
        for name, _, _ in one.kinds():
            before, after = getattr(one, name), getattr(other, name)
            if name not in MEASURED and not np.array_equal(before, after):
                return Difference(key, seconds(stamp - start), name, _plain(before), _plain(after))
    return None


def figures(recorded: Answers, replayed: Answers) -> list[Figure]:
    """Largest values, and how long each state and each reason held, of the times of which both are known."""
    found: list[Figure] = []
    for key in recorded:
        common = recorded[key].keys() & replayed.get(key, {}).keys()
        before, after = (_series(key, {stamp: of[key][stamp] for stamp in common}) for of in (recorded, replayed))
        if not common:
            continue
        if key == CONTROL_STATUS.key:
            found += _limits(before, after)
        found += _values(key, before, after)
    return found


def _limits(before: _Series, after: _Series) -> Iterator[Figure]:
    """Per axis: how much of its limit is used, error bound included, how long it is exceeded, how long it holds."""
    shares, over, holds = ([_of_limits(one)[place] for one in (before, after)] for place in range(3))
    for axis, name in enumerate(AXES):
        yield Figure(f"{name}: largest share of its limit", "%", *(100.0 * one[axis] for one in shares))
        yield Figure(f"{name}: time over its limit", "s", *(one[axis] for one in over))
        yield Figure(f"{name}: time it holds back", "s", *(one[axis] for one in holds))


def _of_limits(series: _Series) -> tuple[Array, Array, Array]:
    margin, active = series.of("margin"), series.of("active")
    limit = np.array([np.zeros(6) if message.limit is None else message.limit for message in series.messages])
    known = limit > 0.0
    share = np.where(known, 1.0 - margin / np.where(known, limit, 1.0), 0.0)
    lasted = series.lasted[:, None]
    return share.max(axis=0), (lasted * (known & (margin < 0.0))).sum(axis=0), (lasted * (active != 0.0)).sum(axis=0)


def _values(key: str, before: _Series, after: _Series) -> Iterator[Figure]:
    for name, kind, _ in before.messages[0].kinds():
        if name in MEASURED:
            continue
        if isinstance(kind, Text):
            yield from _held(f"{key}.{name}", before, after, name)
        elif isinstance(kind, Number) or (isinstance(kind, Vector) and kind.size == 3):
            largest = [float(np.max(np.abs(np.atleast_2d(one.of(name).T).T).max(axis=1))) for one in (before, after)]
            yield Figure(f"{key}.{name}: largest", kind.unit, *largest)


def _held(label: str, before: _Series, after: _Series, field: str) -> Iterator[Figure]:
    """How long each text held; numbers in it change with every message, so that what stands before a colon counts."""
    held: dict[str, list[float]] = {}
    for place, series in enumerate((before, after)):
        for message, lasted in zip(series.messages, series.lasted, strict=True):
            text = getattr(message, field).partition(":")[0]
            held.setdefault(text, [0.0, 0.0])[place] += lasted
    for text, times in sorted(held.items(), key=lambda one: -max(one[1]))[:_REASONS]:
        if text:
            yield Figure(f"{label} {text!r}", "s", *times)


def _series(key: str, said: Mapping[int, Said]) -> _Series:
    stamps = sorted(said)
    times = np.array([seconds(stamp - stamps[0]) for stamp in stamps])
    lasted = np.minimum(np.diff(times, append=times[-1:]), _LASTS)
    return _Series([_message(key, said[stamp]) for stamp in stamps], times, lasted)


def _message(key: str, said: Said) -> Record:
    topic: Topic | None = topic_by_key(key)
    assert topic is not None
    return decode(topic.message, said.payload, topic.cap)[1]


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value
