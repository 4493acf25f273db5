"""The state machine played through without bus and clock."""

from __future__ import annotations

from collections.abc import Callable

from services.task.faults import TaskFault
from services.task.journal import Resumption
from services.task.machine import StateMachine
from services.task.parameters import TaskParameters
from services.task.states import Decision, State
from tests.services.task.toy import Toy

DT = 0.02


class Play:
    """A machine and a toy that does what it decides."""

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
        assert self.state is state, f"{self.state}: {self.machine.reason}"

    def reach(self, state: State) -> Play:
        """Go through a carry up to a state."""
        if state is State.IDLE:
            return self
        if state is State.HOLDING:
            self.machine.command("abort")
            return self
        self.machine.command("start")
        if state in (State.CALIBRATING, State.SEARCHING, State.APPROACHING, State.GRASPING):
            self.to(state)
            return self
        self.to(State.CARRYING)
        if state is State.CARRYING:
            return self
        self.toy.lifted = True
        self.run(2.0)
        self.toy.roll_rate = 0.2
        self.run(20.0, lambda: self.machine.rotation > 1.5)
        self.toy.roll_rate = 0.0
        self.toy.far_height = self.toy.stands
        self.to(State.RELEASING)
        if state is not State.RELEASING:
            self.to(state)
        return self


ORDER = [
    State.IDLE,
    State.CALIBRATING,
    State.SEARCHING,
    State.APPROACHING,
    State.GRASPING,
    State.CARRYING,
    State.RELEASING,
    State.RETREATING,
    State.DONE,
]
