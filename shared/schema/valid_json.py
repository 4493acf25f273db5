"""JSON for programs that are not of this project: numbers are finite, and null stands for what is none.

Python's own writer says NaN and Infinity, which are no JSON: a strict reader refuses the whole document.
"""

from __future__ import annotations

import json
import math
from typing import Any


def valid_json(document: Any, indent: int | None = None) -> str:
    """A document of JSON types, with null in place of every number that is none or without bound."""
    return json.dumps(_finite(document), ensure_ascii=False, allow_nan=False, indent=indent)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(part) for part in value]
    return value
