"""Keys, tokens and attachments of both dialects; of rmw_zenoh's, as another implementation of it makes them."""

from __future__ import annotations

import pytest
from zenoh_ros2_sdk import keyexpr
from zenoh_ros2_sdk.attachment import Attachment
from zenoh_ros2_sdk.entity import EndpointEntity, EntityKind, NodeEntity
from zenoh_ros2_sdk.qos import QosProfile
from zenoh_ros2_sdk.utils import ros2_to_dds_type

from services.bridge_ros2.codec import type_hash
from services.bridge_ros2.mismatches import commanded, heard
from services.bridge_ros2.names import HASHLESS, End, RmwZenoh, Ros2Dds, demangled, mangled, publisher_of
from services.bridge_ros2.parameters import BridgeRos2Parameters
from shared.parameters import Refused

BOOL, TWIST = "std_msgs/msg/Bool", "geometry_msgs/msg/Twist"
HUMBLE = RmwZenoh(3, lambda kind: HASHLESS)
JAZZY = RmwZenoh(3, type_hash)


def end(publishes: bool, topic: str, kind: str, node: str = "/robot", session: str = "far", hash_: str = "") -> End:
    return End(publishes, topic, kind, hash_, node, session)


@pytest.mark.parametrize("dialect", [HUMBLE, JAZZY], ids=["humble", "jazzy"])
def test_keys_are_those_of_the_peer(dialect: RmwZenoh) -> None:
    hash_ = HASHLESS if dialect is HUMBLE else type_hash(TWIST)
    key = keyexpr.topic_keyexpr(3, "/base/cmd_vel", ros2_to_dds_type(TWIST), hash_)
    assert dialect.commanded("/base/cmd_vel", TWIST) == key
    assert dialect.heard("/base/cmd_vel") == "3/base/cmd_vel/*/*"
    assert dialect.kind_of(key) == TWIST


def test_tokens_are_those_of_the_peer() -> None:
    node = NodeEntity(3, "abc", 0, "tandem")
    twist = EndpointEntity(
        node, 2, EntityKind.PUBLISHER, "/base/cmd_vel", mangled(TWIST), type_hash(TWIST), QosProfile().encode()
    )
    flag = EndpointEntity(
        node, 1, EntityKind.SUBSCRIPTION, "/stop", mangled(BOOL), type_hash(BOOL), QosProfile().encode()
    )
    tokens = JAZZY.tokens("abc", "tandem", {"/stop": BOOL}, {"/base/cmd_vel": TWIST})
    assert tokens == [
        keyexpr.node_liveliness_keyexpr(node),
        keyexpr.endpoint_liveliness_keyexpr(flag),
        keyexpr.endpoint_liveliness_keyexpr(twist),
    ]
    assert JAZZY.end(tokens[0]) is None
    assert JAZZY.end(tokens[1]) == End(False, "/stop", BOOL, type_hash(BOOL), "/tandem", "abc")
    assert JAZZY.end(tokens[2]) == End(True, "/base/cmd_vel", TWIST, type_hash(TWIST), "/tandem", "abc")


def test_a_node_in_a_namespace_is_told_by_its_whole_name() -> None:
    token = f"@ros2_lv/3/abc/1/2/MP/%/%left%arm/driver/%stop/{mangled(BOOL)}/{HASHLESS}/::,10:,:,:,,"
    assert HUMBLE.end(token) == End(True, "/stop", BOOL, HASHLESS, "/left/arm/driver", "abc")


def test_attachments_are_those_of_the_peer() -> None:
    publisher = bytes(range(16))
    attachment = JAZZY.attachment(7, 123_456_789, publisher)
    assert attachment == Attachment(7, 123_456_789, publisher).to_bytes() and len(attachment) == 33
    assert publisher_of(attachment) == publisher.hex()
    assert publisher_of(None) == publisher_of(b"") == publisher_of(attachment[:-1]) == ""


def test_the_bridge_on_the_robot_calls_topics_by_themselves() -> None:
    plain, spaced = Ros2Dds(), Ros2Dds("/robot1")
    assert plain.heard("/power/is_emergency") == plain.commanded("/power/is_emergency", BOOL) == "power/is_emergency"
    assert spaced.heard("/power/is_emergency") == "robot1/power/is_emergency"
    assert plain.kind_of("power/is_emergency") == "" and plain.attachment(1, 2, bytes(16)) is None
    assert plain.tokens("abc", "tandem", {"/stop": BOOL}, {}) == []
    token = "@/abc/@ros2_lv/{}/{}power§is_emergency/std_msgs§msg§Bool/:1:1:1,1"
    told = End(True, "/power/is_emergency", BOOL, "", "bridge abc", "abc")
    assert plain.end(token.format("MP", "")) == spaced.end(token.format("MP", "robot1§")) == told
    assert plain.end(token.format("SS", "")) is None and plain.end("@/abc/@ros2_lv") is None


@pytest.mark.parametrize("kind", [BOOL, TWIST])
def test_types_have_two_names(kind: str) -> None:
    assert mangled(kind) == ros2_to_dds_type(kind) and demangled(mangled(kind)) == kind


def test_a_namespace_is_of_the_other_dialect() -> None:
    with pytest.raises(Refused, match="namespace is /robot1: under rmw_zenoh"):
        BridgeRos2Parameters.of({"dialect": "rmw_zenoh", "namespace": "/robot1"})


def test_what_differs_from_the_profile_is_one_line_each() -> None:
    kinds = {"/joint_states": "sensor_msgs/msg/JointState", "/stop": BOOL}
    ends = [end(True, topic, kind) for topic, kind in kinds.items()]
    assert [*heard(ends, kinds, "/stop")] == []
    assert [*heard(ends[1:], kinds, "/stop")] == [
        "nobody publishes /joint_states (sensor_msgs/msg/JointState): is that part of the robot up, and is it called "
        "so there?"
    ]
    left_over = end(True, "/joint_states", "sensor_msgs/msg/JointState", "/left_over")
    assert [*heard([*ends, left_over, end(True, "/stop", BOOL, "/other")], kinds, "/stop")] == [
        "/joint_states has 2 publishers, /left_over and /robot: one of them has to go"
    ]
    assert [*heard([ends[0], end(True, "/stop", TWIST)], kinds, "")] == [
        f"/stop is {TWIST} on the robot (/robot), the profile says {BOOL}"
    ]


def test_what_cannot_be_commanded_is_one_line_each() -> None:
    kinds, hashes = {"/cmd_vel": TWIST}, {TWIST: "RIHS01_9c45"}
    listener = end(False, "/cmd_vel", TWIST, hash_="RIHS01_9c45")
    assert [*commanded([listener], kinds, hashes)] == []
    assert [*commanded([], kinds, hashes)] == [
        f"nobody listens to /cmd_vel ({TWIST}): is that controller loaded, and is it called so there?"
    ]
    (line,) = commanded([end(False, "/cmd_vel", "geometry_msgs/msg/TwistStamped")], kinds, hashes)
    assert "/cmd_vel is geometry_msgs/msg/TwistStamped on the robot" in line
    (line,) = commanded([end(False, "/cmd_vel", TWIST, hash_=HASHLESS)], kinds, hashes)
    assert 'distribution="humble"' in line
    (line,) = commanded([listener, end(True, "/cmd_vel", TWIST, "/teleop")], kinds, hashes)
    assert line == "/cmd_vel is commanded by /teleop, too"
