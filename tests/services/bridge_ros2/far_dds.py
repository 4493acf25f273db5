"""A robot's node in a domain of DDS for tests, as a bridge of ours meets it behind the real zenoh-bridge-ros2dds."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader

from services.ros_robot.dds import LATCHED, LOOPBACK, RELIABLE
from services.ros_robot.dds_types import GRAPH, Encoded, graph, topic
from tests.support import dds


class FarDomain:
    """Publishes and subscribes as a node of ROS 2 does; whatever arrives is kept.

    Attributes:
        dialect: in which a bridge of ours hears of it.
        endpoint: of the program between, for that bridge.
        received: payload and attachment, of which there is none, of each message, by topic.
    """

    dialect = "ros2dds"

    def __init__(self, domain: int, endpoint: str) -> None:
        self.endpoint = endpoint
        self.received: dict[str, list[tuple[bytes, bytes | None]]] = defaultdict(list)
        self._domain = Domain(domain, LOOPBACK)
        self._participant = DomainParticipant(domain)
        self._graph = DataWriter(self._participant, topic(self._participant, "ros_discovery_info", GRAPH), LATCHED)
        self._writers: dict[str, DataWriter[Encoded]] = {}
        self._readers: dict[str, DataReader[Encoded]] = {}

    def advertise(self, name: str, kind: str, latched: bool = False) -> None:
        qos = LATCHED if latched else RELIABLE
        self._writers[name] = DataWriter(self._participant, topic(self._participant, f"rt{name}", kind), qos)
        self._tell()

    def listen(self, name: str, kind: str) -> None:
        def keep(payload: bytes) -> None:
            self.received[name].append((payload, None))

        self._readers[name] = dds.reader(self._participant, f"rt{name}", kind, keep)
        self._tell()

    def publish(self, name: str, payload: bytes) -> None:
        self._writers[name].write(Encoded(payload))

    def withdraw(self, name: str) -> None:
        del self._writers[name]
        self._tell()

    def wanted(self, name: str) -> bool:
        return bool(self._writers[name].matched_sub)

    def close(self) -> None:
        kept: list[Any] = [self._writers, self._readers]
        for each in kept:
            each.clear()

    def _tell(self) -> None:
        ends = [one.guid for one in self._readers.values()], [one.guid for one in self._writers.values()]
        self._graph.write(graph(self._participant.guid, {"robot": ends}))
