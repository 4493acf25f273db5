"""What the rigs of services have in common: one service on a stack of its own, under simulated time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.parameters import Refused
from shared.topics import Query, Topic
from shared.wire.client import Client
from shared.wire.subscription import Received


class ServiceRig:
    """A stack, a participant that plays what surrounds the service, and what the service publishes.

    Attributes:
        surroundings: publishes what a robot's processes do, in a session of its own.
    """

    def __init__(self) -> None:
        self.stack = Stack()
        self._heard: list[list[Received]] = []
        self.new_session()

    def new_session(self) -> None:
        """What surrounds the service was started anew."""
        self.surroundings = Client(self.stack.bus, self.stack.scheduler.clock)

    def hear(self, topic: Topic) -> list[Received]:
        """Every message of a topic since the last call of ``run``, in a list that is kept up."""
        heard: list[Received] = []
        self.stack.client.watch(topic, heard.append)
        self._heard.append(heard)
        return heard

    def every(self, period: Callable[[], float], turn: Callable[[], None]) -> None:
        """Take a turn now, and again and again after a period [s] that is asked for each time."""

        def again() -> None:
            turn()
            self.at(period(), again)

        self.stack.scheduler.soon(again)

    def at(self, after: float, call: Callable[[], None]) -> None:
        """Call something after a time [s]."""
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(after), call)

    def publish(self, topic: Topic, message: Any, valid: bool = True) -> None:
        """Say something as another participant."""
        self.stack.client.publish(topic, message, valid)

    def run(self, duration: float) -> None:
        """Let time pass; keeps what was published meanwhile."""
        for heard in self._heard:
            heard.clear()
        self.stack.run(duration)

    def ask(self, query: Query, request: dict[str, Any]) -> dict[str, Any]:
        """The service's answer."""
        return self.stack.client.ask(query, request, timeout=40.0)

    def refuses(self, words: str, query: Query, request: dict[str, Any]) -> None:
        """The service refuses a request with these words."""
        with pytest.raises(Refused, match=words):
            self.ask(query, request)
