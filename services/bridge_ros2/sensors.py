"""What the robot says, kept as of last: Zenoh's threads store it, and whoever asks decodes it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from services.bridge_ros2.codec import decode
from shared.robot.far_side import Heard
from shared.robot.ros_messages import Unreadable, flag

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Arrived:
    """A message as it arrived.

    Attributes:
        payload: in CDR.
        kind: its type by the network; empty if that does not tell.
        sender: who published it; empty if nothing tells.
    """

    payload: bytes
    kind: str
    sender: str


class Newest(Generic[T]):
    """The newest message of a topic.

    Args:
        kind: its type, such as ``std_msgs/msg/Bool``.
        read: what a message says.
    """

    def __init__(self, kind: str, read: Callable[[Any], T]) -> None:
        self.kind = kind
        self._read = read
        self._newest: tuple[Arrived, int, int] | None = None
        self._heard: Heard[T] | None = None
        self._count = self._seen = 0
        self._refused, self._why = 0, ""

    def offer(self, arrived: Arrived) -> None:
        """Take a message, in Zenoh's thread."""
        self._count += 1
        self._newest = arrived, self._count, time.monotonic_ns()

    @property
    def heard(self) -> Heard[T] | None:
        """The newest one that could be read; asked by one thread only."""
        newest = self._newest
        if newest is None or newest[1] == self._seen:
            return self._heard
        arrived, self._seen, arrival = newest
        try:
            message = _decoded(arrived, self.kind)
            self._heard = Heard(self._read(message), self._seen, arrival, _stamp(message), arrived.sender)
        except Unreadable as problem:
            self._refused, self._why = self._refused + 1, f"{problem}"
        return self._heard

    def forget(self) -> None:
        """Keep nothing of what was heard: it is no longer listened to."""
        self._newest = self._heard = None

    @property
    def refusals(self) -> str:
        """How many messages were refused and why the last one was; empty if none was."""
        return f"{self._refused} refused, the last one: {self._why}" if self._refused else ""


class EmergencyStop:
    """What each publisher said last of the emergency stop.

    Messages carry no stamp, and a late subscriber gets what was latched in any order: so of several publishers none
    replaces another one's word.

    Args:
        kind: type of its messages.
        pressed: the value that means it.
    """

    def __init__(self, kind: str, pressed: bool) -> None:
        self.kind = kind
        self._pressed = pressed
        self._said: dict[str, bool] = {}
        self._doubtful: set[str] = set()
        self._present = 0
        self._turn = threading.Lock()
        self._refused, self._why = 0, ""

    def offer(self, arrived: Arrived) -> None:
        """Take a message, in Zenoh's thread: each one counts, not only the last."""
        try:
            value = flag(_decoded(arrived, self.kind))
        except Unreadable as problem:
            self._refused, self._why = self._refused + 1, f"{problem}"
            return
        with self._turn:
            self._said[arrived.sender] = value is self._pressed
            self._doubtful.discard(arrived.sender)
            self._drop_doubtful()

    def present(self, publishers: int) -> None:
        """Take how many publishers there are, in Zenoh's thread.

        Messages do not tell whose they are by the name that leaves the network. So the word of everybody is in doubt
        when somebody has left, and counts on until as many as there are have spoken since.
        """
        with self._turn:
            if publishers < self._present:
                self._doubtful |= self._said.keys()
            self._present = publishers
            self._drop_doubtful()

    def _drop_doubtful(self) -> None:
        if 0 < self._present <= len(self._said) - len(self._doubtful):
            for sender in self._doubtful:
                del self._said[sender]
            self._doubtful.clear()

    def told(self) -> bool:
        """Whether anybody has said anything."""
        return bool(self._said)

    def pressed_by(self) -> str:
        """Names of those that say that it is pressed; empty if nobody does."""
        with self._turn:
            return ", ".join(sorted(sender[:8] or "the robot" for sender, pressed in self._said.items() if pressed))

    @property
    def refusals(self) -> str:
        """How many messages were refused and why the last one was; empty if none was."""
        return f"{self._refused} refused, the last one: {self._why}" if self._refused else ""


def _decoded(arrived: Arrived, kind: str) -> Any:
    if arrived.kind not in ("", kind):
        raise Unreadable(f"it is {arrived.kind}, the profile says {kind}")
    return decode(arrived.payload, kind)


def _stamp(message: Any) -> int | None:
    """Stamp [ns] of a message that has a header."""
    header = getattr(message, "header", None)
    return None if header is None else int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)
