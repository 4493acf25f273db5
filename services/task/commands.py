"""What a person may ask of the task; the states behind it are the machine's."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from services.task.approach import Approach
from services.task.carry import Carry
from services.task.faults import Kind, Present
from services.task.parameters import TaskParameters
from services.task.states import REACTIONS, Seen, State
from services.task.timers import Held
from shared.messages import GripperState
from shared.parameters import Refused

ABORTED = "aborted: `start` carries on if the panel is held, `reset` begins anew"


class Commands(ABC):
    """Start, abort, release and reset: each is done, or refused with the reason and what to do instead."""

    state: State
    since: float
    reason: str
    grip: bool
    ready: bool
    _settings: TaskParameters
    _approach: Approach | None
    _carry: Carry | None
    _aborted: bool
    _interrupted: bool
    _opening: bool
    _starting: bool
    _opened: Held
    _seen: Seen | None
    _faults: Sequence[Present]

    @abstractmethod
    def _go(self, state: State, reason: str, seen: Seen | None) -> None:
        """Enter a state."""

    def command(self, word: object) -> State:
        """Do what a person asks.

        Raises:
            Refused: with the reason and what to do instead.
        """
        handlers = {
            "start": self._start,
            "abort": self._abort,
            "release": self._release,
            "reset": self._reset,
        }
        if not isinstance(word, str) or word not in handlers:
            raise Refused(f"command is {word!r}, wanted start, abort, release or reset")
        handlers[word]()
        return self.state

    def _start(self) -> None:
        seen = self._known()
        if self.state is State.HOLDING and self.grip:
            blocking = [fault for fault in self._faults if fault.kind in REACTIONS[State.CARRYING]]
            if blocking:
                raise Refused(f"cannot carry on: {blocking[0].sentence}")
            if not _gripper(seen).holding:
                raise Refused("cannot carry on: the gripper holds nothing; `reset` begins anew")
            self._carry_from(seen)
            return self._go(State.CARRYING, "carrying on", seen)
        if self.state is not State.IDLE:
            instead = (
                "`reset` first" if self.state in (State.HOLDING, State.DONE) else "it is at work already"
            )
            raise Refused(f"start in state {self.state.value}: {instead}")
        if problem := self._settings.impossible():
            raise Refused(problem)
        if stopped := self._stopped:
            raise Refused(stopped.sentence)
        if _gripper(seen).holding:
            raise Refused("the gripper holds something: `release` opens it")
        self._open_idle(starting=True)

    def _abort(self) -> None:
        # An abort before it is ready must not be undone by what the journal says.
        self._aborted = not self.ready
        self._go(State.HOLDING, ABORTED, self._seen)

    def _release(self) -> None:
        seen = self._known()
        carry = self._carry
        if self.state is State.RELEASING and carry is not None:
            if carry.asked and not carry.opening:
                carry.let_go(seen)
            carry.asked = True
        elif self.state is State.CARRYING or (self.state is State.HOLDING and self.grip):
            if self.state is State.HOLDING:
                carry = self._carry_from(seen)
            assert carry is not None
            carry.asked = True
            self._go(State.RELEASING, "letting go as asked", seen)
        elif self.state is State.IDLE:
            if stopped := self._stopped:
                raise Refused(stopped.sentence)
            self._open_idle(starting=False)
        else:
            raise Refused(f"release in state {self.state.value}: nothing is held")

    def _reset(self) -> None:
        if self.state not in (State.HOLDING, State.DONE, State.IDLE):
            raise Refused(f"reset in state {self.state.value}: `abort` first")
        gripper = self._known().gripper
        if (self.grip or self._interrupted) and (gripper is None or gripper.holding):
            raise Refused("the gripper holds something: `release` lets it go, `start` carries on")
        self.grip, self._opening, self._approach, self._carry = False, False, None, None
        self._go(State.IDLE, "ready: `tandem task start`", self._seen)

    @property
    def _stopped(self) -> Present | None:
        return next((fault for fault in self._faults if fault.kind is Kind.STOPPED), None)

    def _open_idle(self, starting: bool) -> None:
        self._opening, self._starting, self.since = True, starting, 0.0
        self._opened.reset()

    def _carry_from(self, seen: Seen) -> Carry:
        """Carry on from where the tool is now, with what the robot carries and how far it has turned already."""
        before = self._carry
        home = seen.tool if before is None else seen.tool.rolled_as(before.home)
        nominal = before.nominal if before else None
        self._carry = Carry(self._settings, home, float(seen.tool.position[2]), nominal)
        return self._carry

    def _known(self) -> Seen:
        if self._seen is None or not self.ready:
            raise Refused(f"not yet: {self.reason}")
        return self._seen


def _gripper(seen: Seen) -> GripperState:
    if seen.gripper is None:
        raise Refused("state/gripper is not known: is the robot process running?")
    return seen.gripper
