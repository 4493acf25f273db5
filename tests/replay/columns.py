"""Messages as columns of numbers: a file that needs no class of the product to be read, and that compresses well."""

from __future__ import annotations

import lzma
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgpack
import numpy as np

Place = tuple[str | int, ...]
"""Where a value stands in a message: names of maps and indices of lists."""
Leaves = dict[Place, Any]
"""A message, taken apart: one entry per number, text, truth value, null, and empty map or list."""

_EMPTY: dict[str, Callable[[], Any]] = {"map": dict, "list": list, "null": lambda: None}


def leaves(value: Any) -> Leaves:
    """A decoded message, taken apart."""
    return dict(_walk(value, ()))


def _walk(value: Any, place: Place) -> Iterator[tuple[Place, Any]]:
    if isinstance(value, dict) and value:
        for name, item in value.items():
            yield from _walk(item, (*place, name))
    elif isinstance(value, list) and value:
        for index, item in enumerate(value):
            yield from _walk(item, (*place, index))
    else:
        yield place, value


def build(parts: Leaves) -> Any:
    """The message that was taken apart."""
    if () in parts:
        return parts[()]
    heads: dict[str | int, Leaves] = {}
    for place, value in parts.items():
        heads.setdefault(place[0], {})[place[1:]] = value
    if all(isinstance(head, int) for head in heads):
        return [build(heads[index]) for index in sorted(heads)]
    return {name: build(rest) for name, rest in heads.items()}


def pack(rows: Sequence[Leaves], decimals: Callable[[Place], int | None]) -> list[Any]:
    """Columns of messages.

    Args:
        rows: messages, taken apart.
        decimals: of the floats at a place; None keeps every bit.
    """
    found: dict[tuple[Place, str], tuple[list[int], list[Any]]] = {}
    for number, row in enumerate(rows):
        for place, value in row.items():
            numbers, values = found.setdefault((place, _kind(value)), ([], []))
            numbers.append(number)
            values.append(value)
    columns = []
    for (place, kind), (numbers, values) in found.items():
        where = None if len(numbers) == len(rows) else _planes(np.diff(numbers, prepend=0))
        scale = decimals(place) if kind == "float" else None
        columns.append([list(place), kind, scale, len(numbers), where, _data(kind, values, scale)])
    return [len(rows), columns]


def unpack(packed: list[Any]) -> list[Leaves]:
    """The messages that were packed, taken apart."""
    count, columns = packed
    rows: list[Leaves] = [{} for _ in range(count)]
    for place, kind, scale, size, where, data in columns:
        numbers = range(count) if where is None else np.cumsum(_whole(where, size)).tolist()
        for number, value in zip(numbers, _values(kind, data, size, scale), strict=True):
            rows[number][tuple(place)] = value
    return rows


def write(path: Path, content: Any) -> None:
    """Write what MessagePack can carry, compressed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(lzma.compress(msgpack.packb(content), preset=9 | lzma.PRESET_EXTREME))


def read(path: Path) -> Any:
    """What ``write`` wrote."""
    return msgpack.unpackb(lzma.decompress(path.read_bytes()), strict_map_key=False)


def _kind(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, dict):
        return "map"
    return type(value).__name__


def _data(kind: str, values: list[Any], scale: int | None) -> Any:
    if kind in _EMPTY:
        return None
    if kind == "float" and scale is not None:
        # Smooth signals have small differences.
        return _planes(np.diff(np.rint(np.array(values) * 10.0**scale).astype(np.int64), prepend=0))
    if kind == "float":
        return _planes(np.array(values, dtype=np.float64).view(np.int64))
    if kind in ("int", "bool"):
        return _planes(np.diff(np.array(values, dtype=np.int64), prepend=0))
    texts = list(dict.fromkeys(values))
    return [texts, _planes(np.array([texts.index(value) for value in values], dtype=np.int64))]


def _values(kind: str, data: Any, size: int, scale: int | None) -> list[Any]:
    if kind in _EMPTY:
        return [_EMPTY[kind]() for _ in range(size)]
    if kind == "float" and scale is not None:
        # A quotient of whole numbers is the same float on every machine.
        return [number / 10**scale for number in np.cumsum(_whole(data, size)).tolist()]
    if kind == "float":
        return _whole(data, size).view(np.float64).tolist()
    if kind in ("int", "bool"):
        numbers = np.cumsum(_whole(data, size)).tolist()
        return [bool(number) for number in numbers] if kind == "bool" else numbers
    texts, which = data
    return [texts[index] for index in _whole(which, size).tolist()]


def _planes(numbers: np.ndarray) -> bytes:
    """All first bytes, then all second ones: the upper bytes of small numbers take no room then."""
    folded = (numbers << 1) ^ (numbers >> 63)
    return folded.astype("<i8").view(np.uint8).reshape(-1, 8).T.tobytes()


def _whole(planes: bytes, size: int) -> np.ndarray:
    parts = np.frombuffer(planes, dtype=np.uint8).reshape(8, size)
    folded = np.ascontiguousarray(parts.T).view("<u8").reshape(-1)
    return ((folded >> np.uint64(1)).astype(np.int64)) ^ -(folded & np.uint64(1)).astype(np.int64)
