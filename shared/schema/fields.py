"""Kinds of message fields: what a value must be, checked alike when a message is built and when it is decoded."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from msgspec import Meta

_ROUNDING = 1e-15  # of a norm that was made 1
_NORM_TOLERANCE = 1e-3
FLOAT_ONLY = {float}
_LEAST_INTEGER, _END_OF_INTEGERS = -(2**63), 2**64


class InvalidField(ValueError):
    """A field's value is not what the contract asks; the text says which field, what was given and what is allowed."""


def shown(value: object) -> str:
    """A refused value, for the reason."""
    # Bounded in length and in depth: a refused value comes from anybody, nested a thousand times perhaps.
    text = reprlib.repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _finite(value: object, name: str) -> float:
    if type(value) is not float:
        if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
            raise InvalidField(f"{name} is {shown(value)}, wanted a number")
        try:
            value = float(value)
        except OverflowError:
            raise InvalidField(f"{name} is an integer beyond every float") from None
    if not math.isfinite(value):
        raise InvalidField(f"{name} is {value}, wanted a finite number")
    return value


def _bounded(number: type, above: float = -math.inf, minimum: float = -math.inf, maximum: float = math.inf) -> Any:
    """The type of a number within bounds, for a decoder."""
    given = {"gt": above, "ge": minimum, "le": maximum}
    if above > -math.inf:  # a decoder takes one lower bound: the stricter one
        del given["ge" if above >= minimum else "gt"]
    bounds: dict[str, Any] = {name: bound for name, bound in given.items() if abs(bound) < math.inf}
    return Annotated[number, Meta(**bounds)] if bounds else number


def _range(above: float, minimum: float, maximum: float, unit: str, more: str = "more than") -> str:
    """Bounds in words."""
    if above > -math.inf:
        words = [f"{more} {above:g}"]
    elif minimum > -math.inf and maximum < math.inf:
        return f"{minimum:g} to {maximum:g}" + (unit and f" {unit}")
    else:
        words = [f"at least {minimum:g}"] if minimum > -math.inf else []
    if maximum < math.inf:
        words.append(f"at most {maximum:g}")
    return ", ".join(words) + (unit and f" {unit}")


@dataclass(frozen=True)
class Kind:
    """Kind of a field.

    Attributes:
        unit, doc: for readers and for the generated reference.
        wire: type as which a decoder reads it. A payload that does not fit is read once more without types, and what
            is wrong with it is said by ``check``.
    """

    wire: ClassVar[Any] = Any
    unit: str = ""
    doc: str = ""

    def check(self, value: Any, name: str) -> Any:
        """The value in its canonical form.

        Raises:
            InvalidField: if it is not of this kind.
        """
        raise AssertionError(f"{type(self).__name__} checks nothing")


@dataclass(frozen=True)
class Number(Kind):
    """A finite float, optionally bounded."""

    above: float = -math.inf
    minimum: float = -math.inf
    maximum: float = math.inf

    @property
    def wire(self) -> Any:
        return _bounded(float, self.above, self.minimum, self.maximum)

    def check(self, value: Any, name: str) -> float:
        # The usual case; NaN compares false.
        if type(value) is float and self.above < value < math.inf and self.minimum <= value <= self.maximum:
            return value
        number = _finite(value, name)
        if number <= self.above or not self.minimum <= number <= self.maximum:
            raise InvalidField(
                f"{name} is {number:g}, wanted {_range(self.above, self.minimum, self.maximum, self.unit)}"
            )
        return number


@dataclass(frozen=True)
class Vector(Kind):
    """A read-only float64 array; ``size`` None admits any length. Those of fixed size are checked in a row."""

    size: int | None = 3
    above: float = -math.inf
    minimum: float = -math.inf
    maximum: float = math.inf

    @property
    def wire(self) -> Any:
        element = _bounded(float, self.above, self.minimum, self.maximum)
        # Written so because the number of elements is known at run time only.
        return list.__class_getitem__(element) if self.size is None else tuple.__class_getitem__((element,) * self.size)

    @property
    def any_finite(self) -> bool:
        """Whether finite numbers of the right count are all that is asked."""
        return self.above == self.minimum == -math.inf and self.maximum == math.inf

    def check(self, value: Any, name: str) -> np.ndarray:
        return read_only(self.canonical(self._numbers(value, name), name))

    def _numbers(self, value: Any, name: str) -> Sequence[float]:
        """The elements as finite floats."""
        if isinstance(value, np.ndarray):
            if value.ndim != 1:
                raise InvalidField(f"{name} has shape {value.shape}, wanted ({self.size or 'n'},)")
            value = value.tolist()
        elif type(value) is not list and (isinstance(value, (str, bytes)) or not isinstance(value, Sequence)):
            raise InvalidField(f"{name} is {shown(value)}, wanted {self.size or 'n'} numbers")
        if self.size is not None and len(value) != self.size:
            raise InvalidField(f"{name} has {len(value)} elements, wanted {self.size}")
        # Floats with a finite sum are finite floats: settles the usual case in a fifth of the time.
        if not (set(map(type, value)) <= FLOAT_ONLY and math.isfinite(sum(value))):
            value = [_finite(element, name) for element in value]
        return value

    def canonical(self, numbers: Sequence[float], name: str) -> Sequence[float]:
        """Finite numbers as the field holds them.

        Raises:
            InvalidField: if they are out of bounds.
        """
        least, greatest = min(numbers, default=math.inf), max(numbers, default=-math.inf)
        if least <= self.above or least < self.minimum or greatest > self.maximum:
            allowed = _range(self.above, self.minimum, self.maximum, self.unit, more="above")
            raise InvalidField(f"{name} is {shown(numbers)}, wanted every element {allowed}")
        return numbers


@dataclass(frozen=True)
class Direction(Vector):
    """Unit vector; a norm off by more than 0.001 is refused, a smaller error normalised."""

    _form: ClassVar[str] = "a unit vector [x, y, z]"

    @property
    def any_finite(self) -> bool:
        return False

    def canonical(self, numbers: Sequence[float], name: str) -> Sequence[float]:
        norm = math.hypot(*numbers)
        if abs(norm - 1.0) > _NORM_TOLERANCE:
            raise InvalidField(f"{name} has norm {norm:g}, wanted {self._form}")
        if abs(norm - 1.0) <= _ROUNDING:
            # What was normalised once stays as it is, to the last bit, however often it is read again.
            return numbers
        return tuple(number / norm for number in numbers)


@dataclass(frozen=True)
class Quaternion(Direction):
    """Unit quaternion ``[x, y, z, w]``, checked like a direction."""

    _form: ClassVar[str] = "a unit quaternion [x, y, z, w]"
    size: int | None = 4


def read_only(numbers: Sequence[float]) -> np.ndarray:
    """An array that nobody alters by mistake."""
    array = np.array(numbers, dtype=np.float64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Integer(Kind):
    """Any integer that MessagePack can carry: 64 bits, signed or unsigned."""

    minimum: int = _LEAST_INTEGER

    @property
    def wire(self) -> Any:
        return int if self.minimum == _LEAST_INTEGER else Annotated[int, Meta(ge=self.minimum)]

    def check(self, value: Any, name: str) -> int:
        if type(value) is int and self.minimum <= value < _END_OF_INTEGERS:
            return value
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise InvalidField(f"{name} is {shown(value)}, wanted an integer")
        if not self.minimum <= value < _END_OF_INTEGERS:
            raise InvalidField(f"{name} is {shown(value)}, wanted {self.minimum} to 2^64 - 1")
        return int(value)


@dataclass(frozen=True)
class Boolean(Kind):
    """True or false, nothing that merely counts as such."""

    wire: ClassVar[Any] = bool

    def check(self, value: Any, name: str) -> bool:
        if value is True or value is False:
            return value
        if not isinstance(value, (bool, np.bool_)):
            raise InvalidField(f"{name} is {shown(value)}, wanted true or false")
        return bool(value)


@dataclass(frozen=True)
class Text(Kind):
    """A string, optionally one of a few; a longer one than ``longest`` is cut.

    Texts are retold, and what somebody says at length must not make the message of whoever retells it too large.
    """

    choices: tuple[str, ...] = ()
    longest: int = 2000

    @property
    def wire(self) -> Any:
        return Literal[self.choices] if self.choices else str

    def check(self, value: Any, name: str) -> str:
        if type(value) is str and value in self.choices:
            return value
        if not isinstance(value, str):
            raise InvalidField(f"{name} is {shown(value)}, wanted text")
        if self.choices and value not in self.choices:
            raise InvalidField(f"{name} is {shown(value)}, wanted one of {', '.join(self.choices)}")
        return value[: self.longest]


@dataclass(frozen=True)
class TextList(Kind):
    """Strings, such as joint names."""

    wire: ClassVar[Any] = tuple[str, ...]

    def check(self, value: Any, name: str) -> tuple[str, ...]:
        if isinstance(value, (str, bytes)) or not isinstance(value, Sequence):
            raise InvalidField(f"{name} is {shown(value)}, wanted a list of texts")
        if not all(isinstance(element, str) for element in value):
            raise InvalidField(f"{name} holds something else than text")
        # A subclass, such as numpy's, is no text to an encoder.
        return tuple(element if type(element) is str else str.__str__(element) for element in value)


@dataclass(frozen=True)
class Bytes(Kind):
    """Raw bytes, such as an encoded image."""

    wire: ClassVar[Any] = bytes

    def check(self, value: Any, name: str) -> bytes:
        if not isinstance(value, (bytes, bytearray)):
            raise InvalidField(f"{name} is {type(value).__name__}, wanted bytes")
        return bytes(value)


@dataclass(frozen=True)
class Anything(Kind):
    """Whatever MessagePack can carry."""

    def check(self, value: Any, name: str) -> Any:
        return value


def decided(kind: Kind) -> bool:
    """Whether a value that a decoder has read as the kind's ``wire`` type needs no further check."""
    return type(kind) in (Integer, Boolean, TextList, Bytes) or (type(kind) is Text and bool(kind.choices))
