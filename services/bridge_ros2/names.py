"""Keys and liveliness tokens of the two ways in which ROS 2 travels over Zenoh.

``ros2dds`` is what zenoh-bridge-ros2dds makes of a robot under DDS:

    data    <topic>                                                                payload in CDR, nothing attached
    tokens  @/<session>/@ros2_lv/<MP|MS>/<topic>/<type>/<qos>                      one for each topic, "/" as "§"

``rmw_zenoh`` is what a robot with RMW_IMPLEMENTATION=rmw_zenoh_cpp says itself:

    data    <domain>/<topic>/<type>/<hash>                                         and 33 bytes attached
    tokens  @ros2_lv/<domain>/<session>/<node>/<entity>/<MP|MS>/<enclave>/<namespace>/<node name>
            /<topic>/<type>/<hash>/<qos>                                           one for each end, "/" as "%"
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

HASHLESS = "TypeHashNotSupported"
"""In place of a type's hash on humble, which has none."""
_ATTACHMENT = struct.Struct("<qqB16s")
_DEFAULT_QOS = "::,10:,:,:,,"


@dataclass(frozen=True, slots=True)
class End:
    """A publisher or a subscriber of a topic, as its token tells of it.

    Attributes:
        publishes: a publisher.
        topic: with its leading slash.
        kind: type, such as ``std_msgs/msg/Bool``.
        hash: of the type; empty if it is not told.
        node: name of the node; the session's if it is not told.
        session: of Zenoh.
    """

    publishes: bool
    topic: str
    kind: str
    hash: str
    node: str
    session: str


class Dialect(Protocol):
    """How topics become keys.

    Attributes:
        graph: key expression of all tokens.
    """

    graph: str

    def heard(self, topic: str) -> str:
        """Key expression to subscribe to."""
        ...

    def commanded(self, topic: str, kind: str) -> str:
        """Key to publish under."""
        ...

    def kind_of(self, key: str) -> str:
        """Type of what arrives under a key; empty if the key does not tell it."""
        ...

    def end(self, token: str) -> End | None:
        """Whom a token stands for; None if it is neither a publisher nor a subscriber."""
        ...

    def tokens(self, session: str, node: str, heard: Mapping[str, str], commanded: Mapping[str, str]) -> list[str]:
        """Tokens of a node of our own, in a session of Zenoh: types by topics that it subscribes to and publishes."""
        ...

    def attachment(self, number: int, stamp: int, publisher: bytes) -> bytes | None:
        """What goes with the message of that number, counted from 1, at a stamp [ns] since 1970."""
        ...


class Ros2Dds:
    """Keys of zenoh-bridge-ros2dds.

    Args:
        namespace: that the bridge on the robot is configured to put in front, ``/robot1``; empty if none.
    """

    graph = "@/*/@ros2_lv/**"

    def __init__(self, namespace: str = "") -> None:
        self._namespace = namespace.strip("/")

    def heard(self, topic: str) -> str:
        return f"{self._namespace}{topic}".strip("/") if self._namespace else topic.lstrip("/")

    def commanded(self, topic: str, kind: str) -> str:
        return self.heard(topic)

    def kind_of(self, key: str) -> str:
        return ""

    def end(self, token: str) -> End | None:
        match token.split("/"):
            case ["@", session, "@ros2_lv", "MP" | "MS" as role, key, kind, _]:
                topic = "/" + key.replace("§", "/").removeprefix(f"{self._namespace}/")
                return End(role == "MP", topic, kind.replace("§", "/"), "", f"bridge {session}", session)
        return None

    def tokens(self, session: str, node: str, heard: Mapping[str, str], commanded: Mapping[str, str]) -> list[str]:
        return []

    def attachment(self, number: int, stamp: int, publisher: bytes) -> bytes | None:
        return None


class RmwZenoh:
    """Keys of rmw_zenoh.

    Args:
        domain: ROS_DOMAIN_ID of the robot.
        hash_of: hash of a type, for what is published.
    """

    def __init__(self, domain: int, hash_of: Callable[[str], str]) -> None:
        self._domain, self._hash_of = domain, hash_of
        self.graph = f"@ros2_lv/{domain}/**"

    def heard(self, topic: str) -> str:
        # Whatever its type: another one than is expected is told by its name.
        return f"{self._domain}{topic}/*/*"

    def commanded(self, topic: str, kind: str) -> str:
        return f"{self._domain}{topic}/{mangled(kind)}/{self._hash_of(kind)}"

    def kind_of(self, key: str) -> str:
        return demangled(key.split("/")[-2])

    def end(self, token: str) -> End | None:
        match token.split("/"):
            case ["@ros2_lv", _, session, _, _, "MP" | "MS" as role, _, space, node, topic, kind, hash_, _]:
                name = f"{space}%{node}".replace("%", "/").replace("//", "/")
                return End(role == "MP", topic.replace("%", "/"), demangled(kind), hash_, name, session)
        return None

    def tokens(self, session: str, node: str, heard: Mapping[str, str], commanded: Mapping[str, str]) -> list[str]:
        start = f"@ros2_lv/{self._domain}/{session}/0"
        ends = [("MS", *row) for row in heard.items()] + [("MP", *row) for row in commanded.items()]
        tokens = [f"{start}/0/NN/%/%/{node}"]
        for number, (role, topic, kind) in enumerate(ends, 1):
            what = f"{topic.replace('/', '%')}/{mangled(kind)}/{self._hash_of(kind)}"
            tokens.append(f"{start}/{number}/{role}/%/%/{node}/{what}/{_DEFAULT_QOS}")
        return tokens

    def attachment(self, number: int, stamp: int, publisher: bytes) -> bytes | None:
        return _ATTACHMENT.pack(number, stamp, len(publisher), publisher)


def publisher_of(attachment: bytes | None) -> str:
    """Who has published a message, by what is attached to it; empty if that does not tell."""
    if attachment is None or len(attachment) != _ATTACHMENT.size:
        return ""
    return str(_ATTACHMENT.unpack(attachment)[3].hex())


def mangled(kind: str) -> str:
    """A type as DDS calls it: ``std_msgs::msg::dds_::Bool_``."""
    *package, name = kind.split("/")
    return "::".join((*package, "dds_", f"{name}_"))


def demangled(kind: str) -> str:
    """A type as ROS calls it, of what DDS does; of anything else itself."""
    match kind.split("::"):
        case [*package, "dds_", name] if name.endswith("_"):
            return "/".join((*package, name[:-1]))
    return kind
