"""Parameters of a service: declared once with unit, range and meaning; checked at start and when set at run time."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Literal, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

Vector3 = tuple[float, float, float]
Vector6 = tuple[float, float, float, float, float, float]


class Refused(ValueError):
    """A request or a setting is not granted; the text says what, where, the limit and the remedy."""


def parameter(default: Any, unit: str, minimum: float, maximum: float, doc: str) -> Any:
    """Declare a number, or a vector each element of which is in the range."""
    return Field(default, description=doc, json_schema_extra={"unit": unit, "min": minimum, "max": maximum})


def option(default: Any, doc: str, unit: str = "") -> Any:
    """Declare a parameter that has no range: a choice, a switch, a text, a list."""
    return parameter(default, unit, -math.inf, math.inf, doc)


def check_range(name: str, value: Any, declared: FieldInfo) -> None:
    """Hold a value, or each element of a vector, against the range of a parameter declared by ``parameter``.

    Raises:
        Refused: out of range; the text calls it ``name``.
    """
    extra = declared.json_schema_extra
    if not isinstance(extra, dict):
        return
    for element in value if isinstance(value, tuple) else (value,):
        number = isinstance(element, (int, float)) and not isinstance(element, bool)
        if number and not extra["min"] <= element <= extra["max"]:
            allowed = f"{extra['min']:g} to {extra['max']:g} {extra['unit']}".rstrip()
            raise Refused(f"{name} is {_shown(value)}, allowed is {allowed}")


class Parameters(BaseModel):
    """Base of every service's parameters. Immutable; ``changed`` gives a new, checked set."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True)

    def model_post_init(self, _context: Any) -> None:
        """Check the declared ranges, which pydantic knows for scalars only."""
        for name, info in type(self).model_fields.items():
            check_range(name, getattr(self, name), info)
        self.check()

    def check(self) -> None:
        """Check what concerns several parameters together.

        Raises:
            Refused: with the reason.
        """

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Parameters from names and values.

        Raises:
            Refused: unknown name, wrong type or out of range; one line.
        """
        try:
            return cls(**{name: _as_tuple(value) for name, value in values.items()})
        except ValidationError as problem:
            raise Refused(_one_line(problem, cls)) from None

    def changed(self, values: Mapping[str, Any]) -> Self:
        """These parameters with some replaced; ``model_fields_set`` keeps saying which are not just defaults.

        Raises:
            Refused: as ``of``; nothing is changed then.
        """
        present = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self).of({**present, **values})

    def values(self) -> dict[str, Any]:
        """Name -> value, as ``of`` takes them."""
        return {name: _plain(getattr(self, name)) for name in type(self).model_fields}

    @classmethod
    def restored(cls, values: Mapping[str, Any], chosen: Collection[str]) -> Self:
        """Parameters from what ``values`` gave, and the names of those that are not just defaults.

        Raises:
            Refused: as ``of``.
        """
        defaults = {name: _plain(info.default) for name, info in cls.model_fields.items()}
        return cls.of(
            {name: value for name, value in values.items() if name in chosen or defaults.get(name) != _plain(value)}
        )

    def table(self) -> dict[str, dict[str, Any]]:
        """Name -> value, unit, min, max, doc, as the parameter queries answer."""
        rows = {}
        for name, info in type(self).model_fields.items():
            extra = info.json_schema_extra
            if isinstance(extra, dict):
                rows[name] = {
                    "value": _plain(getattr(self, name)),
                    "unit": extra["unit"],
                    "min": None if extra["min"] == -math.inf else extra["min"],
                    "max": None if extra["max"] == math.inf else extra["max"],
                    "doc": info.description or "",
                }
        return rows


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(element) for element in value]
    if is_dataclass(value):
        return {part.name: _plain(getattr(value, part.name)) for part in fields(value)}
    return value.model_dump() if isinstance(value, BaseModel) else value


def _as_tuple(value: Any) -> Any:
    """Lists, which is what TOML and MessagePack know, as the tuples that immutable parameters hold."""
    if isinstance(value, dict):
        return {name: _as_tuple(element) for name, element in value.items()}
    return tuple(_as_tuple(element) for element in value) if isinstance(value, list) else value


def _shown(value: Any) -> str:
    return str(list(value) if isinstance(value, tuple) else value)


def _one_line(problem: ValidationError, cls: type[Parameters]) -> str:
    first = problem.errors()[0]
    if first["type"] == "value_error":
        return first["msg"].removeprefix("Value error, ")
    # A name may come from anybody, of any length and spelling.
    where = " ".join(".".join(str(part) for part in first["loc"]).split())[:60]
    if first["type"] == "extra_forbidden":
        return f"{where} is no parameter; there are {', '.join(cls.model_fields)}"
    name = str(first["loc"][0])
    wanted = _wanted(cls.model_fields[name].annotation)
    where = name if wanted else where
    given = repr(_plain(first.get("input")))
    return f"{where} is {given[:60]}, wanted {wanted}" if wanted else f"{where} is {given[:60]}: {first['msg']}"


def _wanted(annotation: Any) -> str:
    """Wanted value of a scalar or vector parameter, in words; empty for anything else, which pydantic describes."""
    if get_origin(annotation) is tuple and set(elements := get_args(annotation)) == {float}:
        return f"{len(elements)} numbers"
    if get_origin(annotation) is Literal:
        return "one of " + ", ".join(map(repr, get_args(annotation)))
    return {float: "a finite number", int: "a whole number", bool: "true or false", str: "text"}.get(annotation, "")
