"""Records: everything that is declared once and checked alike wherever it comes from, built here or decoded.

A record is a ``msgspec`` structure whose fields are declared by their kinds. Building one and decoding one end in the
same check, and what has passed it is immutable, finite and of the declared shapes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field
from math import isfinite
from struct import Struct
from typing import Any, ClassVar, NamedTuple, Self, dataclass_transform

import msgspec
from msgspec.structs import force_setattr
from numpy import dtype, float64, frombuffer, ndarray

from shared.schema.fields import FLOAT_ONLY, Anything, InvalidField, Kind, Number, Vector, decided, shown

_SEQUENCES = (list, tuple)
_FLOAT = dtype(float64)


class _Unusual(Exception):
    """A field is not what it usually is."""


class Declared(NamedTuple):
    """A field as its class declares it; the default ``MISSING`` means that it has to be given."""

    kind: Kind
    default: Any


def of(kind: Kind, *, default: Any = MISSING) -> Any:
    """A field of this kind; without a default the record must be given it."""
    return Declared(kind, default)


class _Layout(NamedTuple):
    """Checks of a record's fields.

    Attributes:
        row: name, length and part of the row of each vector of fixed size: they are checked and converted together.
        pack: packs the row.
        special: part and kind of those vectors of which more is asked than finite numbers.
        scalars: names of fields of which only that is asked.
        others: name and kind of every other field.
    """

    row: tuple[tuple[str, int, slice], ...]
    pack: Callable[..., bytes]
    special: tuple[tuple[slice, Vector], ...]
    scalars: tuple[str, ...]
    others: tuple[tuple[str, Kind], ...]


def _layout(declared: Mapping[str, Declared], decoded: bool) -> _Layout:
    """Layout of a record that is built, or of a decoded one, whose decoder has seen to types, lengths and bounds."""
    row, special, scalars, others = [], [], [], []
    size = 0
    for name, (kind, _) in declared.items():
        if isinstance(kind, Vector) and kind.size is not None:
            part = slice(size, size := size + kind.size)
            row.append((name, kind.size, part))
            if not kind.any_finite and not (decoded and type(kind) is Vector):
                special.append((part, kind))
        elif decoded and type(kind) is Number:
            scalars.append(name)
        elif not (decoded and decided(kind)):
            others.append((name, kind))
    return _Layout(tuple(row), Struct(f"{size}d").pack, tuple(special), tuple(scalars), tuple(others))


@dataclass_transform(field_specifiers=(of,), frozen_default=True, eq_default=False)
class _Declaring(msgspec.StructMeta):
    """Makes a structure of the declared fields, and has each object checked that is built."""

    def __new__(mcls, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> Any:
        if any(getattr(base, "_declared", None) for base in bases):
            raise TypeError(f"{name}: a record has its own fields only, and none of {bases[0].__name__}")
        declared = {key: value for key, value in namespace.items() if isinstance(value, Declared)}
        for key, given in namespace.get("__annotations__", {}).items():
            if key not in declared and "ClassVar" not in str(given):
                raise TypeError(f"{name}.{key}: a field of a record is declared by of(...)")
        for key, (kind, default) in declared.items():
            if default is not MISSING:
                declared[key] = Declared(kind, kind.check(default, f"{name}.{key}"))
        namespace["__annotations__"] = {key: kind.wire for key, (kind, _) in declared.items()}
        for key, (_, default) in declared.items():
            if default is MISSING:
                del namespace[key]
            else:
                namespace[key] = default
        namespace["_declared"] = declared
        namespace["_built"], namespace["_decoded"] = _layout(declared, False), _layout(declared, True)
        return super().__new__(mcls, name, bases, namespace, frozen=True, eq=False)

    def __call__(cls, *args: Any, **fields: Any) -> Any:  # noqa: N805 (of a metaclass)
        record = msgspec.StructMeta.__call__(cls, *args, **fields)
        record.settle()
        return record


class Record(msgspec.Struct, metaclass=_Declaring):
    """Base of everything that travels or is kept: every field is checked when the object comes into being."""

    _declared: ClassVar[dict[str, Declared]]
    _built: ClassVar[_Layout]
    _decoded: ClassVar[_Layout]

    def settle(self, decoded: bool = False) -> None:
        """Check every field and bring it into its canonical form: once, right after the fields were set.

        Args:
            decoded: a decoder of this class has set them.

        Raises:
            InvalidField: one of them is not of its kind.
        """
        row, pack, special, scalars, others = self._decoded if decoded else self._built
        try:
            if row:
                numbers: list[float] = []
                for name, size, _ in row:
                    value = getattr(self, name)
                    if not decoded:
                        if type(value) is ndarray and value.dtype is _FLOAT:
                            value = value.tolist()
                        elif type(value) not in _SEQUENCES or not set(map(type, value)) <= FLOAT_ONLY:
                            raise _Unusual
                        if len(value) != size:
                            raise _Unusual
                    numbers += value
                # Floats with a finite sum are finite floats.
                if not isfinite(sum(numbers)):
                    raise _Unusual
                for part, kind in special:
                    own = numbers[part]
                    if (canonical := kind.canonical(own, "")) is not own:
                        numbers[part] = canonical
                # An array over bytes cannot be written to, and takes half the time of one made of a list.
                array = frombuffer(pack(*numbers))
                for name, _, part in row:
                    force_setattr(self, name, array[part])
            for name in scalars:
                if not isfinite(getattr(self, name)):
                    raise _Unusual
        except (_Unusual, InvalidField, TypeError):
            # One by one: that finds out whether it is allowed, or why not.
            others = tuple((name, kind) for name, (kind, _) in self._declared.items())
        for name, one in others:
            value = getattr(self, name)
            checked = one.check(value, name)
            if checked is not value:
                force_setattr(self, name, checked)
        self.check()

    def check(self) -> None:
        """Check what concerns several fields together.

        Raises:
            InvalidField: with the reason.
        """

    @classmethod
    def trusted(cls, *values: Any) -> Self:
        """A record of all values in their order, without any check: for what the program itself has made."""
        record: Self = msgspec.StructMeta.__call__(cls, *values)
        return record

    @classmethod
    def kinds(cls) -> tuple[tuple[str, Kind, Any], ...]:
        """Name, kind and default (``MISSING`` if it has to be given) of each field."""
        return tuple((name, *declared) for name, declared in cls._declared.items())

    @classmethod
    def from_plain(cls, data: Mapping[Any, Any], prefix: str = "") -> Self:
        """The record of a map, as decoded or read from a file; unknown fields are ignored.

        Raises:
            InvalidField: a field is missing, or not of its kind.
        """
        for name, (_, default) in cls._declared.items():
            if default is MISSING and name not in data:
                raise InvalidField(f"{prefix}{name} is missing")
        try:
            return cls(**{name: data[name] for name in cls._declared if name in data})
        except InvalidField as problem:
            raise InvalidField(f"{prefix}{problem}") from None

    def to_plain(self) -> dict[str, Any]:
        """The record as a map of builtin types."""
        plain: dict[str, Any] = msgspec.to_builtins(self, enc_hook=ndarray.tolist, builtin_types=(bytes,))
        return plain

    def replaced(self, **changes: Any) -> Self:
        """The record with some fields changed."""
        return type(self)(**{name: getattr(self, name) for name in self._declared} | changes)


@dataclass(frozen=True)
class RecordOf(Kind):
    """A nested record."""

    record: type[Record] | None = None

    def check(self, value: Any, name: str) -> Record:
        assert self.record is not None
        if isinstance(value, self.record):
            return value
        if not isinstance(value, dict):
            raise InvalidField(f"{name} is {shown(value)}, wanted a map")
        return self.record.from_plain(value, f"{name}.")


@dataclass(frozen=True)
class MapOf(Kind):
    """A map from text to values of one kind."""

    kind: Kind = field(default_factory=Anything)

    def check(self, value: Any, name: str) -> dict[str, Any]:
        if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
            raise InvalidField(f"{name} is {shown(value)}, wanted a map of names and values")
        return {key: self.kind.check(item, f"{name}[{shown(key)}]") for key, item in value.items()}


@dataclass(frozen=True)
class Nullable(Kind):
    """Null, or of another kind."""

    kind: Kind = field(default_factory=Anything)

    def check(self, value: Any, name: str) -> Any:
        return None if value is None else self.kind.check(value, name)
