"""A robot's own Zenoh network for tests: keys, tokens and attachments written out, without the bridge's code."""

from __future__ import annotations

import json
import os
import struct
from collections import defaultdict
from typing import Any

import zenoh
from zenoh import ext
from zenoh_ros2_sdk import keyexpr
from zenoh_ros2_sdk.entity import EndpointEntity, EntityKind, NodeEntity
from zenoh_ros2_sdk.utils import ros2_to_dds_type

HUMBLE = "TypeHashNotSupported"
_QOS = "::,10:,:,:,,"


class FarNetwork:
    """Publishes and subscribes as one of the two dialects does; whatever arrives is kept.

    Attributes:
        endpoint: of the router, for a bridge of ours.
        received: payload and attachment of each message, by topic.
    """

    def __init__(self, endpoint: str, dialect: str) -> None:
        self.endpoint, self.dialect = endpoint, dialect
        config = zenoh.Config()
        for name, value in (
            ("mode", "client"),
            ("connect/endpoints", [endpoint]),
            ("scouting/multicast/enabled", False),
            # What is kept for who comes later has to be told apart.
            ("timestamping/enabled", True),
        ):
            config.insert_json5(name, json.dumps(value))
        self.session = zenoh.open(config)
        self.received: dict[str, list[tuple[bytes, bytes | None]]] = defaultdict(list)
        self._publishers: dict[str, Any] = {}
        self._watched: dict[str, zenoh.Publisher] = {}
        self._tokens: dict[str, Any] = {}
        self._node = NodeEntity(0, str(self.session.info.zid()), 0, "robot")
        self._identity, self._number = os.urandom(16), 0
        self._kept: list[Any] = []

    def key(self, topic: str, kind: str) -> str:
        if self.dialect == "ros2dds":
            return topic.lstrip("/")
        return f"0{topic}/{ros2_to_dds_type(kind)}/{HUMBLE}"

    def advertise(self, topic: str, kind: str, latched: bool = False) -> None:
        key = self.key(topic, kind)
        self._token(topic, kind, EntityKind.PUBLISHER, ":1:1:" if latched else ":1::0,10")
        # What is latched does not tell itself who listens.
        self._publishers[topic] = self._watched[topic] = self.session.declare_publisher(key)
        if latched:
            # The one keeps more than the last word, for the case that several say it.
            kept = ext.CacheConfig(max_samples=10 if self.dialect == "ros2dds" else 1)
            self._publishers[topic] = ext.declare_advanced_publisher(
                self.session, key, cache=kept, publisher_detection=True
            )

    def listen(self, topic: str, kind: str) -> None:
        def keep(sample: zenoh.Sample) -> None:
            attached = sample.attachment
            self.received[topic].append((sample.payload.to_bytes(), attached.to_bytes() if attached else None))

        self._token(topic, kind, EntityKind.SUBSCRIPTION, ":1::1,0")
        self._kept.append(self.session.declare_subscriber(self.key(topic, kind), keep))

    def publish(self, topic: str, payload: bytes) -> None:
        self._number += 1
        attachment = struct.pack("<qqB16s", self._number, 0, 16, self._identity)
        self._publishers[topic].put(payload, attachment=attachment if self.dialect == "rmw_zenoh" else None)

    def withdraw(self, topic: str) -> None:
        self._publishers.pop(topic).undeclare()
        self._tokens.pop(topic).undeclare()

    def wanted(self, topic: str) -> bool:
        return bool(self._watched[topic].matching_status.matching)

    def close(self) -> None:
        self.session.close()

    def _token(self, topic: str, kind: str, role: EntityKind, quality: str) -> None:
        """Declare the token of an end, with the quality of service that it has in DDS."""
        if self.dialect == "ros2dds":
            names = f"{topic.lstrip('/')}/{role.value}".split("/")
            ke, what = "§".join(names[:-1]), kind.replace("/", "§")
            key = f"@/{self.session.info.zid()}/@ros2_lv/{role.value}/{ke}/{what}/{quality}"
        else:
            end = EndpointEntity(self._node, len(self._tokens) + 1, role, topic, ros2_to_dds_type(kind), HUMBLE, _QOS)
            key = keyexpr.endpoint_liveliness_keyexpr(end)
        self._tokens[topic] = self.session.liveliness().declare_token(key)
