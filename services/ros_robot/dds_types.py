"""Types of ROS 2 for CycloneDDS, made of the definitions that rosbags has, and discovery as ROS 2 has it.

CycloneDDS is told every field of a type, by which it checks what arrives; messages themselves are rosbags', and cross
its binding as the bytes that they are on the network.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any
from uuid import UUID

import numpy as np
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.topic import Topic
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from services.ros_robot.ros2_messages import STORE

GRAPH = "rmw_dds_common/msg/ParticipantEntitiesInfo"
"""Type of the topic on which each participant tells its nodes; of another form since iron."""
_GID = 24  # bytes on humble, of which DDS knows the first 16
_HUMBLE = get_typestore(Stores.ROS2_HUMBLE)
# An octet has three names in ROS, and is a number in all of them.
_PLAIN = {"bool": bool, "string": str, "byte": types.uint8, "char": types.uint8}
# They are made by brackets, but are no generic types.
_bounded_str: Any = types.bounded_str
_array: Any = types.array
_sequence: Any = types.sequence


@dataclass
class Encoded:
    """A message as a sample of CycloneDDS; it sends and hands over the bytes as they are."""

    data: bytes

    def serialize(self, **_: Any) -> bytes:
        """What is sent, in CDR with its header."""
        return self.data

    @classmethod
    def deserialize(cls, data: bytes, **_: Any) -> Encoded:
        """What has arrived."""
        return cls(data)

    deserialize_key = deserialize


def topic(participant: DomainParticipant, name: str, kind: str) -> Topic[Any]:
    """A topic of DDS by its name there, of a type such as ``std_msgs/msg/Bool``."""
    made: Topic[Any] = Topic(participant, name, _struct(kind))
    made.data_type = Encoded
    return made


def graph(participant: UUID, nodes: Mapping[str, tuple[Sequence[UUID], Sequence[UUID]]]) -> Encoded:
    """What a participant tells of its nodes: by their names their readers and writers."""
    store, package = _HUMBLE.types, GRAPH.rpartition("/")[0]

    def gid(entity: UUID) -> Any:
        return store[f"{package}/Gid"](data=np.frombuffer(entity.bytes.ljust(_GID, b"\0"), np.uint8))

    told = [
        store[f"{package}/NodeEntitiesInfo"](
            node_namespace="/",
            node_name=name,
            reader_gid_seq=[gid(one) for one in readers],
            writer_gid_seq=[gid(one) for one in writers],
        )
        for name, (readers, writers) in nodes.items()
    ]
    message = store[GRAPH](gid=gid(participant), node_entities_info_seq=told)
    return Encoded(bytes(_HUMBLE.serialize_cdr(message, GRAPH)))


def _described(description: tuple[int, Any]) -> Any:
    what, detail = description
    if what == Nodetype.BASE:
        name, longest = detail
        return _bounded_str[longest] if longest else _PLAIN.get(name) or getattr(types, name)
    if what == Nodetype.NAME:
        return _struct(detail)
    inside, size = detail
    if what == Nodetype.ARRAY:
        return _array[_described(inside), size]
    return _sequence[(_described(inside), size) if size else _described(inside)]


@cache
def _struct(kind: str) -> type[IdlStruct]:
    store = _HUMBLE if kind.startswith("rmw_dds_common/") else STORE
    *package, name = kind.split("/")
    fields = {field: _described(description) for field, description in store.fielddefs[kind][1]}
    return make_idl_struct(name, ".".join((*package, "dds_", f"{name}_")), fields)
