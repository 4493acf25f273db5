"""A sound payload as plain values, and what is said of one that is not."""

from __future__ import annotations

from typing import Any

import msgpack
import pytest

from shared.schema.records import Record
from shared.wire.codec import Rejected, decode

HEADER: dict[str, Any] = {"seq": 7, "session": 3, "stamp": 5, "valid": True}
SAMPLE = HEADER | {
    "force": [1.0, 2.0, 3.0],
    "torque": [0.1, 0.2, 0.3],
    "orientation": [0.0, 0.0, 0.0, 1.0],
    "tool_offset": [0.0, 0.0, 0.2],
    "saturated": False,
}


def rejection(message: type[Record], data: object) -> str:
    with pytest.raises(Rejected) as caught:
        decode(message, msgpack.packb(data))
    text = str(caught.value)
    assert len(text) < 400 and "\n" not in text
    return text
