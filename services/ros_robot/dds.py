"""The simulated robot under ROS 2 with DDS: a participant of CycloneDDS, as a robot's nodes are with its usual RMW.

It stays on this machine, without multicast, unless CYCLONEDDS_URI says otherwise.
"""

from __future__ import annotations

import os
import threading
from collections import defaultdict
from collections.abc import Sequence
from uuid import UUID

from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.util import duration

from services.ros_robot import ros2_messages as messages
from services.ros_robot.dds_types import GRAPH, Encoded, graph, topic
from services.ros_robot.messages import Publication
from services.ros_robot.robot import RosRobot
from shared.parameters import Refused

NODE = "simulated_tiago"
HIGHEST_DOMAIN = 232
"""Beyond it there are no ports."""
LOOPBACK = """
<CycloneDDS><Domain>
  <General>
    <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces><AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>
"""
"""Configuration that keeps CycloneDDS on this machine."""
_SURE = Policy.Reliability.Reliable(duration(milliseconds=100))
RELIABLE = Qos(_SURE, Policy.History.KeepLast(10))
SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
LATCHED = Qos(_SURE, Policy.History.KeepLast(1), Policy.Durability.TransientLocal)
_LOOK_EVERY = 0.1  # [s] whether to end


def connect(robot: RosRobot, address: str) -> DdsAdapter:
    """The robot in a domain of DDS, by its number; ROS_DOMAIN_ID, else 0, if it is empty.

    Raises:
        Refused: it is no number of a domain, or there is no way into that.
    """
    domain = address or os.environ.get("ROS_DOMAIN_ID") or "0"
    if not domain.isdecimal() or int(domain) > HIGHEST_DOMAIN:
        raise Refused(f"address is {domain}: wanted the number of a DDS domain, 0 to {HIGHEST_DOMAIN}")
    try:
        return DdsAdapter(robot, int(domain))
    except DDSException as problem:
        raise Refused(
            f"CycloneDDS does not enter domain {domain} ({problem.msg}): "
            "does CYCLONEDDS_URI name an interface of this machine?"
        ) from None


class DdsAdapter:
    """Topics of a robot in a domain; an ``Adapter``."""

    def __init__(self, robot: RosRobot, domain: int) -> None:
        self._robot = robot
        self._domain = Domain(domain, os.environ.get("CYCLONEDDS_URI", LOOPBACK))
        self._participant = DomainParticipant(domain)
        self._trouble = ""
        self._graph = self._writer("ros_discovery_info", GRAPH, LATCHED)
        self._writers: dict[tuple[str, str], DataWriter[Encoded]] = {}
        self._readers = {
            name: DataReader(self._participant, topic(self._participant, f"rt{name}", messages.of_ros2(kind)), RELIABLE)
            for name, kind in robot.subscriptions.items()
        }
        for name, kind in robot.publications.items():
            # What may be latched is declared with its first message, which tells.
            if kind != "std_msgs/Bool":
                self._publisher(name, kind)
        self._tell_graph()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="dds", daemon=True)
        self._thread.start()

    def publish(self, publications: Sequence[Publication]) -> None:
        for one in publications:
            if (one.topic, one.node) not in self._writers:
                self._publisher(one.topic, one.kind, one.latched, one.node)
                self._tell_graph()
            kind = messages.of_ros2(one.kind)
            message = messages.STORE.types[kind](**messages.fields(one))
            payload = bytes(messages.STORE.serialize_cdr(message, kind))
            try:
                self._writers[one.topic, one.node].write(Encoded(payload))
                self._trouble = ""
            except DDSException as problem:
                self._trouble = f"{one.topic} is not sent: {problem}"

    def watched(self) -> bool:
        return any(writer.matched_sub for (name, _), writer in self._writers.items() if "image" in name)

    def notes(self) -> str:
        return self._trouble

    def close(self) -> None:
        self._closed.set()
        self._thread.join()

    def _publisher(self, name: str, kind: str, latched: bool = False, node: str = "robot") -> None:
        qos = LATCHED if latched else SENSOR if kind.endswith("/Image") else RELIABLE
        self._writers[name, node] = self._writer(f"rt{name}", messages.of_ros2(kind), qos)

    def _writer(self, name: str, kind: str, qos: Qos) -> DataWriter[Encoded]:
        return DataWriter(self._participant, topic(self._participant, name, kind), qos)

    def _tell_graph(self) -> None:
        """Tell which node has which ends: what no node has is nothing to ROS 2."""
        nodes: defaultdict[str, tuple[list[UUID], list[UUID]]] = defaultdict(lambda: ([], []))
        nodes[NODE][0].extend(reader.guid for reader in self._readers.values())
        for (_, node), writer in self._writers.items():
            nodes[NODE if node == "robot" else node][1].append(writer.guid)
        self._graph.write(graph(self._participant.guid, nodes))

    def _listen(self) -> None:
        waiting = WaitSet(self._participant)
        for reader in self._readers.values():
            waiting.attach(ReadCondition(reader, ViewState.Any | SampleState.NotRead | InstanceState.Any))
        while not self._closed.is_set():
            waiting.wait(duration(seconds=_LOOK_EVERY))
            for name, reader in self._readers.items():
                for sample in reader.take(N=10):
                    # Else it tells that a writer has gone.
                    if isinstance(sample, Encoded):
                        kind = messages.of_ros2(self._robot.subscriptions[name])
                        message = messages.STORE.deserialize_cdr(sample.data, kind)
                        self._robot.command(name, messages.read(message))
