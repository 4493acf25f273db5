"""Both ends of a robot process as whoever checks it has them: all that it says, and somebody who commands it.

Neither knows how messages travel: the command's own bus and the tests' bare sessions are both used.
"""

from __future__ import annotations

import re
import secrets
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from shared.messages import Header, Stop
from shared.schema.records import Record
from shared.spatial import Array, rotation_matrix
from shared.topics import (
    COMMAND_EE_TWIST,
    ROBOT,
    SENSOR_CAMERA,
    SENSOR_FT,
    STATE_BASE,
    STATE_EE,
    STATE_GRIPPER,
    STATE_JOINTS,
    STATE_ROBOT,
    STOP,
    TOPICS,
    Topic,
    topic_by_key,
)
from shared.wire.codec import Rejected, decode, encode

ALWAYS = (SENSOR_FT, STATE_JOINTS, STATE_EE, STATE_BASE, STATE_GRIPPER, STATE_ROBOT)
"""What every robot process publishes, whether anybody listens or not."""
OWN = tuple(topic for topic in TOPICS if ROBOT in topic.publishers and topic is not SENSOR_CAMERA)
"""All that it may publish, but for pictures: they are made for those who ask."""
AT_REST, AT_REST_TURNING = 2e-3, 1e-2
"""[m/s], [rad/s] Speeds of a tool below which it stands still."""
KEPT = 2000
"""Messages of each key that are kept."""


@dataclass(frozen=True)
class Heard:
    """One payload with what it says, and when it came [ns of this process' steady clock]."""

    header: Header
    message: Record
    arrival: int
    encoding: str = ""


def _newest(topic: Topic) -> Any:
    """The newest message of a topic, as an attribute of ``Robot``."""
    return property(lambda robot: robot.heard[topic.key][-1].message)


class Robot:
    """What a robot says.

    Attributes:
        heard: the last messages of each key that could be read.
        rejected: key and reason of those that could not.
        tool, sample, status, base, gripper: the newest of their kind.

    Args:
        now_ns: steady clock [ns], by which arrivals are told.
    """

    def __init__(self, now_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self._now_ns = now_ns
        self.heard: dict[str, deque[Heard]] = {}
        self.rejected: list[str] = []

    tool = _newest(STATE_EE)
    sample = _newest(SENSOR_FT)
    status = _newest(STATE_ROBOT)
    base = _newest(STATE_BASE)
    gripper = _newest(STATE_GRIPPER)

    def take(self, key: str, payload: bytes, encoding: str = "") -> None:
        """Take over a payload that arrived under a key; from any thread."""
        arrival, topic = self._now_ns(), topic_by_key(key)
        if topic is None:
            self.rejected.append(f"{key}: no key of the contract")
            return
        try:
            header, message = decode(topic.message, payload, topic.cap)
        except Rejected as problem:
            self.rejected.append(f"{key}: {problem}")
            return
        self.heard.setdefault(key, deque(maxlen=KEPT)).append(Heard(header, message, arrival, encoding))

    def all(self, topic: Topic) -> list[Heard]:
        """What is kept of a topic."""
        return list(self.heard.get(topic.key, ()))

    @property
    def rotation(self) -> Array:
        """Of the tool in base (3, 3)."""
        return rotation_matrix(self.tool.orientation)

    @property
    def speed(self) -> float:
        """Of the tool's origin [m/s]."""
        return float(np.linalg.norm(self.tool.linear))

    def at_rest(self) -> bool:
        """Whether the tool stands still."""
        return self.speed < AT_REST and float(np.linalg.norm(self.tool.angular)) < AT_REST_TURNING

    def base_at_rest(self) -> bool:
        """Whether the base stands still."""
        return bool((np.abs(self.base.velocity) < (2e-3, 2e-3, 4e-3)).all())

    def counted(self, what: str) -> int:
        """How many cases of that kind the robot has named so far, in this project's words."""
        cases = re.findall(rf"{what}[^;,]*?: (\d+)|(\d+) [^;,]*?{what}", self.status.reason)
        return sum(int(number) for case in cases for number in case if number)


class Commander:
    """Whoever commands: each ``send`` is what ``make`` gives on ``topic``, a command or a payload.

    Attributes:
        make: gives the next command; None sends nothing.
        number: of the last message.

    Args:
        put: sends a payload under a key.
        topic: of the commands.
        now_ns: its steady clock [ns].
    """

    def __init__(
        self,
        put: Callable[[str, bytes], None],
        topic: Topic = COMMAND_EE_TWIST,
        now_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self.topic = topic
        self.make: Callable[[], Record | bytes | None] = lambda: None
        self.number = 0
        self.put = put
        self._now_ns = now_ns
        self._id = secrets.randbits(62)

    def send(self) -> None:
        """Send the next command, if there is one."""
        made = self.make()
        if made is not None:
            self.put(self.topic.key, made if isinstance(made, bytes) else self.payload(made))

    def payload(
        self, message: Record, valid: bool = True, number: int | None = None, stamp: int | None = None
    ) -> bytes:
        """A message with the next sequence number and of this instant, or of the past."""
        if number is None:
            self.number += 1
        sequence = self.number if number is None else number
        return encode(message, Header(sequence, self._id, stamp or self._now_ns(), valid))

    def stop(self, engaged: bool, reason: str = "", valid: bool = True) -> None:
        """Engage or release the stop."""
        self.put(STOP.key, self.payload(Stop(engaged, reason), valid))
