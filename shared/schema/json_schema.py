"""Records as JSON Schema: how a recording says what its messages are, to programs that know nothing of this project."""

from __future__ import annotations

import math
from typing import Any

from shared.schema.fields import Boolean, Bytes, Direction, Integer, Kind, Number, Text, TextList, Vector
from shared.schema.records import MISSING, MapOf, Nullable, Record, RecordOf


def json_schema(record: type[Record], beside: type[Record] | None = None) -> dict[str, Any]:
    """JSON Schema (2020-12) of a record's map, units in the descriptions.

    Args:
        record: whose fields.
        beside: another record, whose fields stand in the same map, such as a message's header.
    """
    kinds = (*(beside.kinds() if beside else ()), *record.kinds())
    return {
        "type": "object",
        "title": record.__name__,
        "description": record.__doc__ or "",
        "properties": {name: _described(kind) for name, kind, _ in kinds},
        "required": [name for name, _, default in kinds if default is MISSING],
    }


def _described(kind: Kind) -> dict[str, Any]:
    about = ", ".join(part for part in (kind.unit and f"[{kind.unit}]", kind.doc) if part)
    return _of(kind) | ({"description": about} if about else {})


def _of(kind: Kind) -> dict[str, Any]:
    match kind:
        case Nullable():
            return {"anyOf": [_of(kind.kind), {"type": "null"}]}
        case MapOf():
            return {"type": "object", "additionalProperties": _of(kind.kind)}
        case RecordOf():
            return json_schema(kind.record) if kind.record else {"type": "object"}
        case Vector():
            least, most = (-1.0, 1.0) if isinstance(kind, Direction) else (kind.minimum, kind.maximum)
            length = {} if kind.size is None else {"minItems": kind.size, "maxItems": kind.size}
            return {"type": "array", "items": _number(kind.above, least, most)} | length
        case Number():
            return _number(kind.above, kind.minimum, kind.maximum)
        case Integer():
            return {"type": "integer", "minimum": kind.minimum}
        case Boolean():
            return {"type": "boolean"}
        case TextList():
            return {"type": "array", "items": {"type": "string"}}
        case Text():
            return {"type": "string"} | ({"enum": [*kind.choices]} if kind.choices else {})
        case Bytes():
            return {"type": "string", "contentEncoding": "base64"}
        case _:
            return {}


def _number(above: float, minimum: float, maximum: float) -> dict[str, Any]:
    bounds = {"exclusiveMinimum": above, "minimum": minimum, "maximum": maximum}
    return {"type": "number"} | {name: bound for name, bound in bounds.items() if math.isfinite(bound)}
