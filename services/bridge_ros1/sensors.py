"""What the robot says, kept as of last: rospy calls these in threads of its own, one for each publisher."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Collection
from typing import Any, Generic, TypeVar

from shared.clock import seconds
from shared.robot.far_side import Heard
from shared.robot.ros_messages import Unreadable, flag

T = TypeVar("T")


class Newest(Generic[T]):
    """The newest message of a topic; callable with one, as a subscriber's callback.

    Attributes:
        heard: it; None before the first one.

    Args:
        read: what a message says.
    """

    def __init__(self, read: Callable[[Any], T]) -> None:
        self.heard: Heard[T] | None = None
        self._read = read
        self._turn = threading.Lock()
        self._refused, self._why = 0, ""

    def __call__(self, message: Any) -> None:
        arrival = time.monotonic_ns()
        try:
            read = self._read(message)
        except Unreadable as problem:
            with self._turn:
                self._refused, self._why = self._refused + 1, f"{problem}, from {sender(message)}"
            return
        with self._turn:
            number = self.heard.number + 1 if self.heard else 1
            self.heard = Heard(read, number, arrival, stamp(message), sender(message))

    def silence(self) -> float:
        """Time [s] since the newest message; infinite before the first one."""
        heard = self.heard
        return seconds(time.monotonic_ns() - heard.arrival) if heard else math.inf

    def forget(self) -> None:
        """Keep nothing of what was heard: it is no longer listened to."""
        with self._turn:
            self.heard = None

    @property
    def refusals(self) -> str:
        """How many messages were refused and why the last one was; empty if none was."""
        return f"{self._refused} refused, the last one: {self._why}" if self._refused else ""


class EmergencyStop:
    """What each publisher said last of the emergency stop; callable with a message.

    A late subscriber gets what latching publishers said last in the order of their registration, and no message has a
    stamp: so of several publishers none replaces another one's word.

    Args:
        pressed: the value that means it.
    """

    def __init__(self, pressed: bool) -> None:
        self._pressed = pressed
        self._said: dict[str, tuple[bool, int]] = {}
        self._turn = threading.Lock()

    def __call__(self, message: Any) -> None:
        with self._turn:
            self._said[sender(message)] = (flag(message) is self._pressed, time.monotonic_ns())

    def told(self) -> bool:
        """Whether anybody has said anything."""
        return bool(self._said)

    def pressed_by(self) -> str:
        """Names of those that say that it is pressed; empty if nobody does."""
        with self._turn:
            return ", ".join(sorted(name for name, (pressed, _) in self._said.items() if pressed))

    def present(self, publishers: Collection[str]) -> None:
        """Drop the word of who is gone, once somebody who is there has said something since."""
        with self._turn:
            latest = max((at for name, (_, at) in self._said.items() if name in publishers), default=0)
            gone = [name for name, (_, at) in self._said.items() if name not in publishers and at < latest]
            for name in gone:
                del self._said[name]


def sender(message: Any) -> str:
    """Name of the node that published a message."""
    return str(getattr(message, "_connection_header", {}).get("callerid", ""))


def stamp(message: Any) -> int | None:
    """Stamp [ns] of a message that has a header."""
    header = getattr(message, "header", None)
    return None if header is None else int(header.stamp.to_nsec())
