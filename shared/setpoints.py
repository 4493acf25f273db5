"""Commands that hold until the next one: gripper and head, cut to what the robot can do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Generic, TypeVar

from shared.records import Record
from shared.service import Inputs
from shared.topics import Topic

M = TypeVar("M", bound=Record)
Ranges = Mapping[str, tuple[float, float]]
"""Least and greatest value of each field of a command, by its name."""


class Setpoint(Generic[M]):
    """The newest command of a topic.

    Attributes:
        topic: of the command.
        clamped: number of commands that asked for more than there is.
        doubtful: number of commands that their publisher marked as not to be trusted; they are not executed.

    Args:
        topic: of the command.
        ranges: what the robot can do.
    """

    def __init__(self, topic: Topic[M], ranges: Ranges) -> None:
        self.topic = topic
        self._ranges = ranges
        self.clamped = 0
        self.doubtful = 0

    def take(self, inputs: Inputs) -> M | None:
        """What is to be executed from now on, once for each command."""
        command = inputs.get(self.topic)
        if command is None or not command.new:
            return None
        if not command.header.valid:
            self.doubtful += 1
            return None
        asked = {name: getattr(command.message, name) for name in self._ranges}
        able = {
            name: min(max(asked[name], least), greatest) for name, (least, greatest) in self._ranges.items()
        }
        if able == asked:
            return command.message
        self.clamped += 1
        return replace(command.message, **able)
