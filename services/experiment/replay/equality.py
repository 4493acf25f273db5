"""Whether a service answers as it did: byte by byte, or from when on, or where it first differs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import msgpack

from services.experiment.replay.recorded import Answers, Life, Said
from services.experiment.replay.replay import Replayed
from shared.clock import seconds

MEASURED = {"solve_us"}
"""Fields that measure the computer: nothing that a service was given decides them."""
Place = str
"""Of a value in a message, such as ``marker.position[2]``."""


@dataclass(frozen=True)
class Difference:
    """The first one.

    Attributes:
        key: under which the answer was said.
        time: of it [s], from the first answer on.
        place: of the value; empty if the replay has no answer.
        recorded, replayed: the values.
    """

    key: str
    time: float
    place: Place
    recorded: Any
    replayed: Any


@dataclass(frozen=True)
class Equality:
    """How the answers of one life compare, and what is known of why.

    Attributes:
        compared: answers of which both could be known.
        equal: of them, to the last bit; but for what measures the computer, and for the number of the message where
            not all that the service took is known.
        first: difference.
        from_on: time [s] from which on all are equal; None if the last one is not.
        unheard: answers that the replay gives and that the recording did not hear.
        untold: answers after the last word on what the service took.
        whole, missing, lost, gaps: as ``Life`` and ``Replayed`` have them.
    """

    compared: int
    equal: int
    first: Difference | None
    from_on: float | None
    unheard: int
    untold: int
    whole: bool
    missing: int
    lost: int
    gaps: int


def equality(life: Life, replayed: Replayed, near: float = 0.0) -> Equality:
    """Compares what was recorded with what a replay without changes gives.

    Args:
        life: as recorded.
        replayed: of it.
        near: relative and absolute difference that two numbers may have all the same: 0 on the same machine; another
            processor may add up in another order.
    """
    start = min((stamp for said in life.answers.values() for stamp in said), default=0)
    ignored = MEASURED if life.whole and not replayed.missing else MEASURED | {"seq"}
    compared = equal = untold = 0
    different: list[tuple[int, Difference]] = []
    for stamp, key, said in _in_order(life.answers):
        if stamp > life.known_until:
            untold += 1
            continue
        compared += 1
        again = replayed.answers.get(key, {}).get(stamp)
        found = _first_difference(said, again, ignored, near)
        equal += found is None
        if found is not None:
            different.append((stamp, Difference(key, seconds(stamp - start), *found)))
    unheard = sum(len(said.keys() - life.answers.get(key, {}).keys()) for key, said in replayed.answers.items())
    last = max((stamp for stamp, _ in different), default=start - 1)
    after = [stamp for stamp, _, _ in _in_order(life.answers) if last < stamp <= life.known_until]
    return Equality(
        compared,
        equal,
        different[0][1] if different else None,
        seconds(after[0] - start) if after else None,
        unheard,
        untold,
        life.whole,
        replayed.missing,
        life.lost,
        life.gaps,
    )


def _in_order(answers: Answers) -> list[tuple[int, str, Said]]:
    return sorted(((stamp, key, one) for key, said in answers.items() for stamp, one in said.items()), key=_when)


def _when(one: tuple[int, str, Said]) -> tuple[int, str]:
    return one[:2]


def _first_difference(said: Said, again: Said | None, ignored: set[str], near: float) -> tuple[Place, Any, Any] | None:
    """Place and both values of the first difference; None if there is none."""
    if again is None:
        return "", None, None
    if said.payload == again.payload:
        return None
    before, after = (msgpack.unpackb(one.payload) for one in (said, again))
    found = _differences(_without(before, ignored), _without(after, ignored), "")
    return next((one for one in found if not _near(*one[1:], near)), None)


def _without(message: Mapping[str, Any], ignored: set[str]) -> dict[str, Any]:
    return {name: value for name, value in message.items() if name not in ignored}


def _differences(before: Any, after: Any, place: Place) -> Iterator[tuple[Place, Any, Any]]:
    if isinstance(before, dict) and isinstance(after, dict):
        for name in {**before, **after}:
            inner = f"{place}.{name}" if place else name
            yield from _differences(before.get(name, "nothing"), after.get(name, "nothing"), inner)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, pair in enumerate(zip(before, after, strict=True)):
            yield from _differences(*pair, f"{place}[{index}]")
    elif type(before) is not type(after) or before != after or _signs_differ(before, after):
        yield place, before, after


def _near(before: Any, after: Any, near: float) -> bool:
    both = isinstance(before, float) and isinstance(after, float)
    return near > 0.0 and both and math.isclose(before, after, rel_tol=near, abs_tol=near)


def _signs_differ(before: Any, after: Any) -> bool:
    """Of zeros, which are equal and no more than that."""
    return isinstance(before, float) and math.copysign(1.0, before) != math.copysign(1.0, after)


def told(service: str, found: Equality) -> list[str]:
    """The comparison in sentences."""
    part = "outputs equal to the last bit"
    lines = [f"{service}: {found.equal:,} of {found.compared:,} {part}"]
    if (first := found.first) is not None:
        what = f"{first.place} was {first.recorded!r}, replayed {first.replayed!r}"
        what = what if first.place else "nothing is said at that moment in the replay"
        lines.append(f"first difference: {first.key} at {first.time:.4f} s: {what}")
        if found.from_on is not None:
            lines.append(f"all are equal from {found.from_on:.4f} s on")
    if not found.whole:
        lines.append(f"{service} was running when the recording began: what it knew by then is not in it")
    if found.missing:
        lines.append(f"{found.missing:,} messages that {service} took were not heard by the recording")
    if found.gaps:
        lines.append(f"{found.gaps} times the recording missed what {service} told of the messages it took")
    if found.lost:
        lines.append(f"{found.lost:,} outputs were not heard by the recording, so they are not compared")
    if found.untold:
        lines.append(
            f"the last {found.untold:,} outputs are not compared: what {service} took then was not told any more"
        )
    return lines
