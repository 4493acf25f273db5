"""What a case is expected to answer: texts and times of every message, floats of every tenth of a busy topic."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.replay import columns
from tests.replay.cases import Case
from tests.replay.columns import Leaves, Place
from tests.replay.player import Answers, Said

EXPECTED = Path(__file__).parent / "expected"
ANEW = "python -m tests.replay expect"
TOLERANCE = 1e-9
"""Relative and absolute, of floats: another processor adds up in another order."""
_BUSY, _EVERY = 1000, 10
"""Of more messages than this under a key, the floats of every so many are kept."""
_LOWER_BITS = 40
"""Of a float's 52 bits behind the point are kept, which is a thousandth of the tolerance."""
_ABSENT = "nothing"

Expected = dict[str, list[Leaves]]
"""For each key its messages, taken apart; floats may be missing."""


def reduced(answers: Answers) -> Expected:
    """What is kept of answers."""
    return {key: [_kept(number, one, len(said)) for number, one in enumerate(said)] for key, said in answers.items()}


def _sampled(number: int, count: int) -> bool:
    return count <= _BUSY or number % _EVERY == 0


def _kept(number: int, said: Said, count: int) -> Leaves:
    parts: Leaves = {("(heard)",): said.time, **columns.leaves(said.content)}
    if _sampled(number, count):
        return {place: _rounded(value) if type(value) is float else value for place, value in parts.items()}
    return {place: value for place, value in parts.items() if type(value) is not float}


def _rounded(value: float) -> float:
    bits = np.float64(value).view(np.int64) >> (52 - _LOWER_BITS) << (52 - _LOWER_BITS)
    return float(np.int64(bits).view(np.float64))


def save(path: Path, answers: Answers) -> None:
    """Write what is expected from now on."""
    columns.write(path, {key: columns.pack(rows, lambda place: None) for key, rows in reduced(answers).items()})


def load(path: Path) -> Expected:
    """Read what is expected."""
    return {key: columns.unpack(packed) for key, packed in columns.read(path).items()}


def path_of(case: Case) -> Path:
    """Where a case's expectation is kept."""
    return EXPECTED / f"{case.name}.xz"


def differences(case: str, expected: Expected, answers: Answers) -> Iterator[str]:
    """Every difference in words, in the order of keys and messages."""
    for key in sorted({*expected, *answers}):
        wanted, got = expected.get(key, []), answers.get(key, [])
        for number, (row, said) in enumerate(zip(wanted, got, strict=False)):
            for place, want, have in _fields(row, said, _sampled(number, len(wanted))):
                yield (
                    f"{case}: {key}, message {number} at {said.time * 1e-9:.4f} s: {_named(place)} is {have!r}, "
                    f"wanted {want!r}"
                )
        if len(wanted) != len(got):
            yield f"{case}: {key}: {len(got)} messages, wanted {len(wanted)}"


def _fields(row: Leaves, said: Said, sampled: bool) -> Iterator[tuple[Place, Any, Any]]:
    parts: Leaves = {("(heard)",): said.time, **columns.leaves(said.content)}
    for place in {**row, **parts}:
        want, have = row.get(place, _ABSENT), parts.get(place, _ABSENT)
        if not sampled and want is _ABSENT and type(have) is float:
            continue
        if not _alike(want, have):
            yield place, want, have


def _alike(want: Any, have: Any) -> bool:
    if type(want) is not type(have):
        return False
    if type(want) is float:
        return math.isclose(want, have, rel_tol=TOLERANCE, abs_tol=TOLERANCE)
    return bool(want == have)


def _named(place: Place) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).removeprefix(".")


def told(found: Iterator[str], most: int = 10) -> str:
    """The first differences, how many more there are, and how to make what is expected anew; empty without any."""
    lines = list(found)
    if not lines:
        return ""
    more = [f"... and {len(lines) - most} more"] if len(lines) > most else []
    return "\n".join([*lines[:most], *more, f"If the change is meant: {ANEW}, and say why in the commit."])
