"""The toy robot in real time, around a task that runs as a process."""

from __future__ import annotations

import time

from shared.messages import ControlTarget, TaskStatus
from shared.parameters import Refused
from shared.schema.records import Record
from shared.topics import CONTROL_TARGET, SENSOR_CAMERA, TASK_COMMAND, TASK_STATUS, Topic
from shared.wire.subscription import Received
from tests.services.task.robot import TICK, Robot
from tests.support.stand_in import StandIn
from tests.support.wait import eventually


class Surroundings(StandIn):
    """Robot, wrench service, controller and person in one; collects what the task says.

    What it said is looked for in all that it said since some instant of the steady clock [ns], which all processes of
    a machine share: whoever looks at the newest message alone may come too late to see it.

    Attributes:
        leads: whether the person does what the task waits for.
    """

    def __init__(self, endpoint: str) -> None:
        super().__init__(endpoint, "task", self._act, TICK)
        self.robot = Robot(self.client.watch)
        self.leads = False

    def _act(self, number: int) -> list[tuple[Topic, Record, bool]]:
        if self.leads:
            self.robot.person()
        return self.robot.tick(number)

    def looked_at(self) -> bool:
        """Whether somebody wants pictures of the camera."""
        return self.bus.wanted(SENSOR_CAMERA.key)

    @property
    def pictured(self) -> int:
        """When the camera took its last picture [ns]; 0 before the first."""
        return self.bus.last_sent_ns[SENSOR_CAMERA.key]

    def ask(self, command: object) -> str:
        """The state after a command; asked again if the robot's state was too old just then."""

        def answer() -> str | None:
            try:
                return self.client.ask(TASK_COMMAND, {"command": command}, timeout=30.0)["state"]
            except Refused as refusal:
                if "not yet" in str(refusal) or "is not known" in str(refusal):
                    return None
                raise

        return eventually(answer, 60.0, f"an answer to {command}")

    def says(self, state: str, *words: str, since: int = 0, within: float = 60.0) -> Received[TaskStatus]:
        """The first status of a state with a reason that has these words."""

        def fits(status: Received[TaskStatus]) -> bool:
            message = status.message
            asked = status.header.stamp >= since and message.state == state
            return asked and all(word in message.reason for word in words)

        return eventually(
            lambda: next(filter(fits, tuple(self.robot.received[TASK_STATUS.key])), None),
            within,
            lambda: f"{state}, {words}; the task is {self.robot.state}: {self.robot.reason}",
        )

    def targets(self, since: int) -> list[ControlTarget]:
        """All targets, at least one."""
        received = self.robot.received[CONTROL_TARGET.key]
        return eventually(lambda: [r.message for r in tuple(received) if r.header.stamp >= since], 30.0, "a target")

    def begun(self, state: str) -> None:
        """Start, and wait for a state."""
        self.says("idle", "ready")
        now = time.monotonic_ns()
        self.ask("start")
        self.says(state, since=now)

    def carrying(self) -> None:
        self.begun("carrying")
        self.robot.toy.lifted = True
        self.says("carrying", "carrying;")
