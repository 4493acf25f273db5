"""ROS 2 messages as bytes (CDR), by rosbags: types by their names, such as ``std_msgs/msg/Bool``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from shared.robot.ros_messages import Unreadable

# What a bridge reads and writes has not changed from humble to jazzy, its hashes neither.
_STORE = get_typestore(Stores.ROS2_HUMBLE)


def decode(payload: bytes, kind: str) -> Any:
    """A message of its bytes; arrays in it are views of them.

    Raises:
        Unreadable: they are no message of that type.
    """
    try:
        return _STORE.deserialize_cdr(payload, kind)
    except SerdeError as problem:
        raise Unreadable(f"{len(payload)} bytes are no {kind} ({problem})") from None


def encode(message: Any) -> bytes:
    """The bytes of a message that ``new`` has made."""
    return bytes(_STORE.serialize_cdr(message, message.__msgtype__))


def new(kind: str, **fields: Any) -> Any:
    """A message; its arrays of numbers have to be ``numbers``."""
    return _STORE.types[kind](**fields)


def numbers(values: Any) -> np.ndarray:
    """Numbers as the codec needs them.

    It copies an array's bytes whatever its type: an integer 1 would become 5e-324.
    """
    return np.ascontiguousarray(values, dtype=np.float64)


def type_hash(kind: str) -> str:
    """Hash of a type, by which ROS 2 since iron tells versions of a type apart."""
    return _STORE.hash_rihs01(kind)


def prepare(kinds: Iterable[str]) -> None:
    """Have the code for these types made: else the first message of each takes a tenth of a second."""
    for kind in kinds:
        _STORE.get_msgdef(kind)
