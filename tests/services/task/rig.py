"""The state machine alone with a toy of a robot, and the task on a stack with that robot behind the contract."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from services.task.faults import TaskFault
from services.task.geometry import Pose
from services.task.journal import Resumption
from services.task.machine import StateMachine
from services.task.parameters import TaskParameters
from services.task.states import Decision, State
from services.task.task import Task
from shared.clock import nanoseconds
from shared.parameters import Refused
from shared.topics import CONTROL_TARGET, SENSOR_CAMERA, TASK_COMMAND, Topic, health_topic
from shared.wire.subscription import Received
from tests.services.task.robot import TICK, Robot
from tests.services.task.toy import Toy
from tests.support.service_rig import ServiceRig

DT = 0.02
ORDER = [state for state in State if state is not State.HOLDING]
"""The states of a carry in which nothing goes wrong."""


class MachineRig:
    """The state machine without bus and clock, and a toy that does what it decides.

    Attributes:
        changed: what is observed otherwise than the toy has it.
    """

    def __init__(self, **parameters: object) -> None:
        self.settings = TaskParameters(**parameters)
        self.toy = Toy(self.settings)
        self.machine = StateMachine(self.settings)
        self.faults: list[TaskFault] = []
        self.states: list[State] = []
        self.decision = Decision("")
        self.changed: dict[str, object] = {}
        self.opened_in: set[State] = set()
        self.machine.resume(Resumption(), self.toy.seen())

    @property
    def state(self) -> State:
        return self.machine.state

    @property
    def reason(self) -> str:
        return self.machine.reason

    def command(self, word: str) -> State:
        return self.machine.command(word)

    def refuses(self, word: str, words: str) -> None:
        """The machine refuses a command with these words."""
        with pytest.raises(Refused, match=words):
            self.machine.command(word)

    def tick(self, lost: bool = False) -> Decision:
        state = self.state
        seen = None if lost else self.toy.seen(**self.changed)
        decision = self.decision = self.machine.step(seen, self.faults, DT)
        if decision.target is not None:
            self.toy.target = decision.target
        if decision.gripper is not None:
            self.toy.wanted = decision.gripper.opening
            if decision.gripper.opening > self.toy.opening:
                self.opened_in |= {state}
        self.toy.advance(DT)
        if not self.states or self.states[-1] is not self.state:
            self.states.append(self.state)
        return decision

    def run(self, duration: float, until: Callable[[], bool] = lambda: False) -> None:
        for _ in range(round(duration / DT)):
            if until():
                return
            self.tick()

    def to(self, state: State, within: float = 60.0) -> None:
        self.run(within, lambda: self.state is state)
        assert self.state is state, f"{self.state}: {self.reason}"

    def reach(self, state: State) -> MachineRig:
        """Go through a carry up to a state."""
        if state is State.HOLDING:
            self.command("abort")
        if state in (State.IDLE, State.HOLDING):
            return self
        self.command("start")
        if ORDER.index(state) <= ORDER.index(State.CARRYING):
            self.to(state)
            return self
        self.to(State.CARRYING)
        self.toy.lifted = True
        self.run(2.0)
        self.toy.roll_rate = 0.2
        self.run(20.0, lambda: self.machine.rotation > 1.5)
        self.toy.roll_rate = 0.0
        self.toy.far_height = self.toy.stands
        self.to(State.RELEASING)
        self.to(state)
        return self

    def lifted(self) -> MachineRig:
        """Go on to carrying, with half the weight taken over."""
        self.reach(State.CARRYING)
        self.toy.lifted = True
        self.run(2.0)
        return self

    def halted(self, name: str, detail: str = "") -> None:
        """A step with a fault."""
        self.faults = [TaskFault(name, detail)]
        self.tick()


class Rig(ServiceRig):
    """A stack with the task, and a robot on it; the task can be killed and started again.

    Attributes:
        lag: time [s] since the images were taken that the camera sends now.
        leads: whether the person does what the task waits for.
    """

    def __init__(self, folder: Path | None = None, **parameters: Any) -> None:
        super().__init__()
        self.folder = folder
        self.settings = TaskParameters.of(parameters)
        self.robot = Robot(self.stack.client.watch, self.settings)
        self.health = self.stack.client.watch(health_topic("task"))
        self.leads = True
        self.lag = 0.0
        self._ticks = 0
        self.start_task()
        self.every(lambda: TICK, self._tick)

    def start_task(self) -> None:
        self.task = Task(self.settings, lambda: self.stack.now, self.folder)
        self.runner = self.stack.add(self.task)

    def kill_task(self) -> None:
        """As SIGKILL does: it says nothing any more."""
        self.runner.poll = lambda behind=False: None  # type: ignore[method-assign]
        self.runner.next_deadline = lambda: 2**62  # type: ignore[method-assign]
        self.stack.bus._servers.pop(TASK_COMMAND.key, None)

    def _tick(self) -> None:
        if self.leads:
            self.robot.person()
        now = self.stack.scheduler.clock.now_ns()
        for topic, message, valid in self.robot.tick(self._ticks):
            taken = now - nanoseconds(self.lag if topic is SENSOR_CAMERA else 0.0)
            self.surroundings.publish(topic, message, valid, taken)
        self._ticks += 1

    def tell(self, command: str) -> str:
        """The state after a command."""
        return self.ask(TASK_COMMAND, {"command": command})["state"]

    def refuses_to(self, command: object, words: str) -> None:
        """The task refuses a command with these words."""
        self.refuses(words, TASK_COMMAND, {"command": command})

    def until(self, state: str, within: float = 60.0) -> Rig:
        self.stack.run(within, lambda: self.state == state)
        assert self.state == state, f"{self.state}: {self.reason}"
        return self

    def run(self, duration: float) -> None:
        """Let time pass; what the task says is kept until ``forget``."""
        self.stack.run(duration)

    def forget(self) -> None:
        """Keep nothing of what the task has said so far."""
        for received in self.robot.received.values():
            received.clear()

    def begun(self) -> Rig:
        self.run(1.0)
        self.tell("start")
        return self

    def carrying(self) -> Rig:
        self.begun().until("carrying")
        self.leads = False
        self.toy.lifted = True
        self.run(2.0)
        return self

    def said(self, topic: Topic) -> list[Received]:
        """Every message of a topic from the task since ``forget``."""
        return self.robot.received[topic.key]

    def last(self, topic: Topic) -> Any:
        """The newest message of a topic from the task, None before the first."""
        return self.robot.last(topic)

    @property
    def toy(self) -> Toy:
        return self.robot.toy

    @property
    def state(self) -> str:
        """The task's state, as it says."""
        return self.robot.state

    @property
    def reason(self) -> str:
        return self.robot.reason

    @property
    def target(self) -> Pose:
        message = self.last(CONTROL_TARGET)
        return Pose.of(message.position, message.orientation)
