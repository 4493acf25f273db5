"""A robot on the bench of whoever checks it: what it says, who commands it, and the time that passes meanwhile."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial

from services.cli.check.heard import OWN, Commander, Robot
from shared.clock import Clock, SteadyClock, nanoseconds, seconds
from shared.topics import COMMAND_EE_TWIST, Topic
from shared.wire.bus import Bus

PERIOD = 0.01  # [s] between two commands
_LOOK = 0.005  # [s] between two looks at what is awaited


class Bench:
    """Waits for what a robot is to do, and has it commanded meanwhile.

    Attributes:
        robot: what it says.

    Args:
        bus: on which it is.
        clock: steady.
        sleep: lets so much time [s] pass.
    """

    def __init__(self, bus: Bus, clock: Clock | None = None, sleep: Callable[[float], None] = time.sleep) -> None:
        self._bus, self._sleep = bus, sleep
        self._clock = clock or SteadyClock()
        self.robot = Robot(self._clock.now_ns)
        self._commanders: list[Commander] = []
        self._due = 0
        for topic in OWN:
            bus.subscribe(topic.key, partial(self.robot.take, topic.key))

    def commander(self, topic: Topic = COMMAND_EE_TWIST) -> Commander:
        """Another one who commands, a hundred times a second while something is awaited."""
        commander = Commander(self._bus.publish, topic, self._clock.now_ns)
        self._commanders.append(commander)
        return commander

    def silence(self, topic: Topic) -> float:
        """Time [s] since the last message of a topic; infinite if there was none."""
        heard = self.robot.all(topic)
        return seconds(self._clock.now_ns() - heard[-1].arrival) if heard else math.inf

    def within(self, limit: float, condition: Callable[[], object]) -> bool:
        """Whether a condition becomes true within a time [s]."""
        deadline = self._clock.now_ns() + nanoseconds(limit)
        while not condition():
            if self._clock.now_ns() > deadline:
                return False
            self._sleep(_LOOK)
            if self._clock.now_ns() >= self._due:
                self._due = max(self._due + nanoseconds(PERIOD), self._clock.now_ns())
                for commander in self._commanders:
                    commander.send()
        return True

    def throughout(self, duration: float, condition: Callable[[], object]) -> bool:
        """Whether a condition stays true for a time [s]; returns as soon as it is false."""
        return not self.within(duration, lambda: not condition())

    def wait(self, duration: float) -> None:
        """Let so much time [s] pass."""
        self.within(duration, lambda: False)
