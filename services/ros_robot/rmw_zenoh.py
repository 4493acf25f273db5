"""The simulated robot under ROS 2 with rmw_zenoh, spoken by zenoh-ros2-sdk: another implementation than the bridge's.

The router that rmw_zenoh wants (`rmw_zenohd`) runs in here if none listens at the address.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from zenoh import ext
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber
from zenoh_ros2_sdk.qos import QosDurability, QosProfile, QosReliability
from zenoh_ros2_sdk.session import ZenohSession

from services.ros_robot import ros2_messages as messages
from services.ros_robot.messages import Publication
from services.ros_robot.robot import RosRobot
from shared.parameters import Refused
from shared.wire.endpoint import BusError, check_endpoint, port_of
from shared.wire.zenoh_sessions import open_router, prepare, router_settings

USUAL = "tcp/127.0.0.1:7448"
NODE = "simulated_tiago"
_SENSOR = QosProfile(reliability=QosReliability.BEST_EFFORT, history_depth=5)
_LATCHED = QosProfile(durability=QosDurability.TRANSIENT_LOCAL, history_depth=1)


def connect(robot: RosRobot, address: str) -> RmwZenohAdapter:
    """The robot at a router's endpoint, ``tcp/host:port``.

    Raises:
        Refused: it has another form.
    """
    endpoint = address or USUAL
    try:
        check_endpoint("address is", endpoint)
    except BusError as problem:
        raise Refused(str(problem)) from None
    if not endpoint.startswith("tcp/"):
        raise Refused(f"address is {endpoint}, wanted tcp/<address>:<port>")
    return RmwZenohAdapter(robot, endpoint)


class RmwZenohAdapter:
    """Topics of a robot at a router; an ``Adapter``."""

    def __init__(self, robot: RosRobot, endpoint: str) -> None:
        self._robot, self._endpoint = robot, endpoint
        prepare()
        self._router = _router(endpoint)
        host = endpoint.removeprefix("tcp/").rpartition(":")[0]
        self._where: dict[str, Any] = {"router_ip": host, "router_port": port_of(endpoint), "domain_id": 0}
        self._session = ZenohSession.get_instance(host, port_of(endpoint))
        self._publishers: dict[tuple[str, str], ROS2Publisher] = {}
        for topic, kind in robot.publications.items():
            # What may be latched is declared with its first message, which tells.
            if kind != "std_msgs/Bool":
                self._publisher(topic, kind, latched=False)
        self._subscribers = [
            ROS2Subscriber(topic, callback=self._taker(topic), node_name=NODE, **self._typed(kind))
            for topic, kind in robot.subscriptions.items()
        ]

    def publish(self, publications: Sequence[Publication]) -> None:
        for publication in publications:
            publisher = self._publisher(publication.topic, publication.kind, publication.latched, publication.node)
            publisher.publish(**messages.fields(publication))

    def watched(self) -> bool:
        images = [publisher for (topic, _), publisher in self._publishers.items() if "image" in topic]
        return any(publisher.pub.matching_status.matching for publisher in images)

    def notes(self) -> str:
        info = self._session.session.info
        if self._router is not None or [*info.routers_zid()]:
            return ""
        return f"no Zenoh router answers at {self._endpoint}"

    def close(self) -> None:
        self._session.session.close()
        if self._router is not None:
            self._router.close()

    def _publisher(self, topic: str, kind: str, latched: bool, node: str = "robot") -> ROS2Publisher:
        known = self._publishers.get((topic, node))
        if known is not None:
            return known
        name, qos = NODE if node == "robot" else node, _LATCHED if latched else _SENSOR
        publisher = ROS2Publisher(topic, node_name=name, qos=qos, **self._typed(kind))
        if latched:
            # Its own publishers keep nothing for who comes later.
            publisher.pub.undeclare()
            cache = ext.CacheConfig(max_samples=1)
            session = self._session.session
            publisher.pub = ext.declare_advanced_publisher(
                session, publisher.keyexpr, cache=cache, publisher_detection=True
            )
        self._publishers[topic, node] = publisher
        return publisher

    def _typed(self, kind: str) -> dict[str, Any]:
        # By default it looks for definitions on the network, and computes hashes that are wrong.
        name = messages.of_ros2(kind)
        humble = os.environ.get("ROS_DISTRO", "humble")[0] < "i"
        hash_ = "TypeHashNotSupported" if humble else messages.STORE.hash_rihs01(name)
        return {
            "msg_type": name,
            "msg_definition": messages.definition(name),
            "type_hash": hash_,
            **self._where,
        }

    def _taker(self, topic: str) -> Callable[[Any], None]:
        return lambda message: self._take(topic, message)

    def _take(self, topic: str, message: Any) -> None:
        self._robot.command(topic, messages.read(message))


def _router(endpoint: str) -> Any:
    try:
        # Nodes are peers, between which it hands on nothing: as `rmw_zenohd` does it tells them of each other.
        return open_router(router_settings(endpoint) | {"scouting/gossip/enabled": True})
    except BusError:
        # Another one's, or on another machine.
        return None
