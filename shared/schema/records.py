"""Records: everything that travels, made of the kinds of fields, checked alike when built and when decoded."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from typing import Any, NamedTuple, Self

import numpy as np

from shared.schema.fields import FLOAT_ONLY, InvalidField, Kind, Vector, read_only, shown

_SEQUENCES = (list, tuple)


@dataclass(frozen=True)
class RecordOf(Kind):
    """A nested record; null where the contract says so."""

    record: type[Record] | None = None
    nullable: bool = False

    def check(self, value: Any, name: str) -> Record | None:
        assert self.record is not None
        if isinstance(value, self.record):
            return value
        if value is None and self.nullable:
            return None
        if not isinstance(value, dict):
            raise InvalidField(f"{name} is {shown(value)}, wanted a map")
        return self.record.from_plain(value, f"{name}.")

    def plain(self, value: Record | None) -> dict[str, Any] | None:
        return None if value is None else value.to_plain()


@dataclass(frozen=True)
class MapOf(Kind):
    """A map from text to records of one type."""

    record: type[Record] | None = None

    def check(self, value: Any, name: str) -> dict[str, Any]:
        assert self.record is not None
        if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
            raise InvalidField(f"{name} is {shown(value)}, wanted a map with text keys")
        one = RecordOf(record=self.record)
        return {key: one.check(item, f"{name}[{shown(key)}]") for key, item in value.items()}

    def plain(self, value: dict[str, Record]) -> dict[str, Any]:
        return {key: item.to_plain() for key, item in value.items()}


def of(kind: Kind, default: Any = MISSING) -> Any:
    """A dataclass field of this kind; without a default the message must carry it."""
    return field(default=default, metadata={"kind": kind})


class _Place(NamedTuple):
    """A field of a record; ``part`` is its share of all vectors of fixed size in a row, None for every other kind."""

    name: str
    kind: Kind
    default: Any
    part: slice | None


class _Layout(NamedTuple):
    """The fields of a record class in their order, those that are vectors of fixed size, and those to convert."""

    places: tuple[_Place, ...]
    vectors: tuple[tuple[str, Vector, Any], ...]
    unplain: tuple[tuple[str, Kind], ...]


def _in_a_row(vectors: tuple[tuple[str, Vector, Any], ...], data: Mapping[Any, Any]) -> np.ndarray | None:
    """All vectors of fixed size, checked and converted together in a third of the time that they take one by one.

    None if any of them is not what is usual: the checks one by one find out whether it is allowed, and say why not.
    """
    numbers: list[float] = []
    changes: list[tuple[int, Vector]] = []
    for name, kind, default in vectors:
        value = data.get(name, default)
        if type(value) is np.ndarray and value.ndim == 1:
            value = value.tolist()
        if type(value) not in _SEQUENCES or len(value) != kind.size:
            return None
        if not kind.any_finite:
            changes.append((len(numbers), kind))
        numbers += value
    # Floats with a finite sum are finite floats.
    if not (set(map(type, numbers)) <= FLOAT_ONLY and math.isfinite(sum(numbers))):
        return None
    try:
        for begin, kind in changes:
            part = slice(begin, begin + (kind.size or 0))
            numbers[part] = kind.canonical(numbers[part], "")
    except InvalidField:
        return None
    return read_only(numbers)


@dataclass(frozen=True, eq=False)
class Record:
    """Base of everything that travels: every field is checked when the object is built."""

    def __post_init__(self) -> None:
        values = vars(self)
        self._fill(values, values)
        self.check()

    def check(self) -> None:
        """Check what concerns several fields together.

        Raises:
            InvalidField: with the reason.
        """

    @classmethod
    @cache
    def kinds(cls) -> tuple[tuple[str, Kind, Any], ...]:
        """Name, kind and default (``MISSING`` if it has to be given) of each field."""
        return tuple((item.name, item.metadata["kind"], item.default) for item in fields(cls))

    @classmethod
    @cache
    def _layout(cls) -> _Layout:
        places = []
        vectors = []
        begin = 0
        for name, kind, default in cls.kinds():
            part = None
            if isinstance(kind, Vector) and kind.size is not None:
                part = slice(begin, begin := begin + kind.size)
                vectors.append((name, kind, default))
            places.append(_Place(name, kind, default, part))
        unplain = tuple((name, kind) for name, kind, _ in cls.kinds() if type(kind).plain is not Kind.plain)
        return _Layout(tuple(places), tuple(vectors), unplain)

    @classmethod
    def from_plain(cls, data: dict[Any, Any], prefix: str = "") -> Self:
        """The record of a decoded map; unknown fields are ignored.

        Raises:
            InvalidField: a field is missing, or not of its kind.
        """
        # Filled in directly: the generated constructor would take as long again as all the checks.
        record = object.__new__(cls)
        try:
            cls._fill(vars(record), data)
            record.check()
        except InvalidField as problem:
            raise InvalidField(f"{prefix}{problem}") from None
        return record

    @classmethod
    def _fill(cls, values: dict[str, Any], data: Mapping[Any, Any]) -> None:
        layout = cls._layout()
        row = _in_a_row(layout.vectors, data) if layout.vectors else None
        for name, kind, default, part in layout.places:
            if row is not None and part is not None:
                values[name] = row[part]
                continue
            value = data.get(name, default)
            if value is MISSING:
                raise InvalidField(f"{name} is missing")
            values[name] = kind.check(value, name)

    def to_plain(self) -> dict[str, Any]:
        """The record as a map that MessagePack can carry."""
        plain = vars(self).copy()
        for name, kind in self._layout().unplain:
            plain[name] = kind.plain(plain[name])
        return plain
