"""Commands that hold until the next one: gripper and head, cut to what the robot can do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Generic, TypeVar

from shared.schema.records import Record
from shared.service import Inputs
from shared.topics import Topic

M = TypeVar("M", bound=Record)
Ranges = Mapping[str, tuple[float, float]]
"""Least and greatest value of each field of a command, by its name."""
OLDEST = 1.0
"""[s] Age up to which a command is taken over. Its sender may have been stopped between deciding and sending, and what
was right then, to open the fingers for one, may be wrong now."""


class HeldCommand(Generic[M]):
    """The newest command of a topic.

    Attributes:
        topic: of the commands.
        clamped: number of commands that asked for more than there is.
        doubtful: number of commands that their publisher marked as not to be trusted; they are not executed.
        late: number of commands that were too old; they are not executed.
        stopped: number of commands that came while a stop was engaged; they are not executed, later neither.

    Args:
        topic: of the commands.
        ranges: what the robot can do.
    """

    def __init__(self, topic: Topic[M], ranges: Ranges) -> None:
        self.topic = topic
        self._ranges = ranges
        self.clamped = 0
        self.doubtful = 0
        self.late = 0
        self.stopped = 0

    def take(self, inputs: Inputs, stopped: bool = False) -> M | None:
        """Command to execute from now on, once for each that arrived.

        Args:
            inputs: of this step.
            stopped: whether a stop is engaged, or was until this step.
        """
        command = inputs.get(self.topic)
        if command is None or not command.new:
            return None
        if not command.header.valid:
            self.doubtful += 1
            return None
        if command.age > OLDEST:
            self.late += 1
            return None
        if stopped:
            self.stopped += 1
            return None
        asked = {name: getattr(command.message, name) for name in self._ranges}
        able = {name: min(max(asked[name], least), greatest) for name, (least, greatest) in self._ranges.items()}
        if able == asked:
            return command.message
        self.clamped += 1
        return command.message.replaced(**able)

    @property
    def counts(self) -> tuple[tuple[int, str], ...]:
        """How many commands were not executed as sent, and why."""
        what = f"{self.topic.key.rpartition('/')[2]} commands"
        return (
            (self.clamped, f"{what} clamped"),
            (self.doubtful, f"{what} refused as marked invalid"),
            (self.late, f"{what} refused as older than {OLDEST:g} s"),
            (self.stopped, f"{what} refused while stopped"),
        )
