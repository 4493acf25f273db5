"""Kinds of message fields: what a value must be, checked alike when a message is built and when it is decoded."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, ClassVar, Self

import numpy as np

_QUATERNION_TOLERANCE = 1e-3
_FLOAT_ONLY = {float}


class InvalidField(ValueError):
    """A field's value is not what the contract asks; the text says which field, what was given and what is allowed."""


def _shown(value: object) -> str:
    # Bounded in length and in depth: a refused value comes from anybody, nested a thousand times if he likes.
    text = reprlib.repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _finite(value: object, name: str) -> float:
    if type(value) is not float:
        if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
            raise InvalidField(f"{name} is {_shown(value)}, wanted a number")
        try:
            value = float(value)
        except OverflowError:
            raise InvalidField(f"{name} is an integer beyond every float") from None
    if not math.isfinite(value):
        raise InvalidField(f"{name} is {value}, wanted a finite number")
    return value


@dataclass(frozen=True)
class Kind:
    """What a field holds. ``unit`` and ``doc`` are for readers and for the generated reference."""

    unit: str = ""
    doc: str = ""

    def check(self, value: Any, name: str) -> Any:
        """The value in its canonical form.

        Raises:
            InvalidField: if it is not of this kind.
        """
        raise AssertionError(f"{type(self).__name__} checks nothing")

    def plain(self, value: Any) -> Any:
        """The value as MessagePack can carry it."""
        return value


@dataclass(frozen=True)
class Number(Kind):
    """A finite float, optionally bounded."""

    above: float = -math.inf
    minimum: float = -math.inf
    maximum: float = math.inf

    def check(self, value: Any, name: str) -> float:
        number = _finite(value, name)
        if number <= self.above or not self.minimum <= number <= self.maximum:
            raise InvalidField(f"{name} is {number:g}, wanted {self._range()}{self.unit and ' ' + self.unit}")
        return number

    def _range(self) -> str:
        lower = f"more than {self.above:g}" if self.above > -math.inf else f"at least {self.minimum:g}"
        if self.maximum == math.inf:
            return lower
        return f"{lower}, at most {self.maximum:g}"


@dataclass(frozen=True)
class Vector(Kind):
    """A read-only float64 array; ``size`` None admits any length."""

    size: int | None = 3
    above: float = -math.inf
    minimum: float = -math.inf

    def check(self, value: Any, name: str) -> np.ndarray:
        return _read_only(self.numbers(value, name))

    def numbers(self, value: Any, name: str) -> Sequence[float]:
        """The elements as finite floats; raises as ``check``."""
        if isinstance(value, np.ndarray):
            if value.ndim != 1:
                raise InvalidField(f"{name} has shape {value.shape}, wanted ({self.size or 'n'},)")
            value = value.tolist()
        elif type(value) is not list and (isinstance(value, (str, bytes)) or not isinstance(value, Sequence)):
            raise InvalidField(f"{name} is {_shown(value)}, wanted {self.size or 'n'} numbers")
        if self.size is not None and len(value) != self.size:
            raise InvalidField(f"{name} has {len(value)} elements, wanted {self.size}")
        # Floats with a finite sum are finite floats: settles the usual case in a fifth of the time.
        if not (set(map(type, value)) <= _FLOAT_ONLY and math.isfinite(sum(value))):
            value = [_finite(element, name) for element in value]
        least = min(value, default=math.inf)
        if least <= self.above or least < self.minimum:
            bound = f"above {self.above:g}" if self.above > -math.inf else f"at least {self.minimum:g}"
            raise InvalidField(
                f"{name} is {_shown(value)}, wanted every element {bound}{self.unit and ' ' + self.unit}"
            )
        return value

    def plain(self, value: np.ndarray) -> list[float]:
        return value.tolist()


@dataclass(frozen=True)
class Quaternion(Vector):
    """Unit quaternion ``[x, y, z, w]``; a norm off by more than 0.001 is refused, a smaller error normalised."""

    size: int | None = 4

    def check(self, value: Any, name: str) -> np.ndarray:
        numbers = self.numbers(value, name)
        norm = math.hypot(*numbers)
        if abs(norm - 1.0) > _QUATERNION_TOLERANCE:
            raise InvalidField(f"{name} has norm {norm:g}, wanted a unit quaternion [x, y, z, w]")
        return _read_only([number / norm for number in numbers])


def _read_only(numbers: Sequence[float]) -> np.ndarray:
    array = np.array(numbers, dtype=np.float64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Integer(Kind):
    """Any integer that MessagePack can carry: 64 bits, signed or unsigned."""

    minimum: int = -(2**63)

    def check(self, value: Any, name: str) -> int:
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise InvalidField(f"{name} is {_shown(value)}, wanted an integer")
        if not self.minimum <= value < 2**64:
            raise InvalidField(f"{name} is {_shown(value)}, wanted {self.minimum} to 2^64 - 1")
        return int(value)


@dataclass(frozen=True)
class Boolean(Kind):
    """True or false, nothing that merely counts as such."""

    def check(self, value: Any, name: str) -> bool:
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidField(f"{name} is {_shown(value)}, wanted true or false")
        return bool(value)


@dataclass(frozen=True)
class Text(Kind):
    """A string, optionally one of a few."""

    choices: tuple[str, ...] = ()

    def check(self, value: Any, name: str) -> str:
        if not isinstance(value, str):
            raise InvalidField(f"{name} is {_shown(value)}, wanted text")
        if self.choices and value not in self.choices:
            raise InvalidField(f"{name} is {_shown(value)}, wanted one of {', '.join(self.choices)}")
        return value


@dataclass(frozen=True)
class TextList(Kind):
    """Strings, such as joint names."""

    def check(self, value: Any, name: str) -> tuple[str, ...]:
        if isinstance(value, (str, bytes)) or not isinstance(value, Sequence):
            raise InvalidField(f"{name} is {_shown(value)}, wanted a list of texts")
        if not all(isinstance(element, str) for element in value):
            raise InvalidField(f"{name} holds something else than text")
        return tuple(value)

    def plain(self, value: tuple[str, ...]) -> list[str]:
        return list(value)


@dataclass(frozen=True)
class Bytes(Kind):
    """Raw bytes, such as an encoded image."""

    def check(self, value: Any, name: str) -> bytes:
        if not isinstance(value, (bytes, bytearray)):
            raise InvalidField(f"{name} is {type(value).__name__}, wanted bytes")
        return bytes(value)


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
            raise InvalidField(f"{name} is {_shown(value)}, wanted a map")
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
            raise InvalidField(f"{name} is {_shown(value)}, wanted a map with text keys")
        one = RecordOf(record=self.record)
        return {key: one.check(item, f"{name}[{_shown(key)}]") for key, item in value.items()}

    def plain(self, value: dict[str, Record]) -> dict[str, Any]:
        return {key: item.to_plain() for key, item in value.items()}


def of(kind: Kind, default: Any = MISSING) -> Any:
    """A dataclass field of this kind; without a default the message must carry it."""
    return field(default=default, metadata={"kind": kind})


@dataclass(frozen=True, eq=False)
class Record:
    """Base of everything that travels: every field is checked when the object is built."""

    _kinds: ClassVar[tuple[tuple[str, Kind, Any], ...]]

    def __post_init__(self) -> None:
        values = vars(self)
        for name, kind, _ in self.kinds():
            values[name] = kind.check(values[name], name)
        self.check()

    def check(self) -> None:
        """Check what concerns several fields together.

        Raises:
            InvalidField: with the reason.
        """

    @classmethod
    def kinds(cls) -> tuple[tuple[str, Kind, Any], ...]:
        """Name, kind and default (``MISSING`` if it has to be given) of each field."""
        if "_kinds" not in cls.__dict__:
            cls._kinds = tuple((item.name, item.metadata["kind"], item.default) for item in fields(cls))
        return cls._kinds

    @classmethod
    def from_plain(cls, data: dict[Any, Any], prefix: str = "") -> Self:
        """The record of a decoded map; unknown fields are ignored.

        Raises:
            InvalidField: a field is missing, or not of its kind.
        """
        # Filled in directly: the generated constructor would take as long again as all the checks.
        record = object.__new__(cls)
        values = vars(record)
        try:
            for name, kind, default in cls.kinds():
                value = data.get(name, default)
                if value is MISSING:
                    raise InvalidField(f"{name} is missing")
                values[name] = kind.check(value, name)
            record.check()
        except InvalidField as problem:
            raise InvalidField(f"{prefix}{problem}") from None
        return record

    def to_plain(self) -> dict[str, Any]:
        """The record as a map that MessagePack can carry."""
        values = vars(self)
        return {name: kind.plain(values[name]) for name, kind, _ in self.kinds()}
