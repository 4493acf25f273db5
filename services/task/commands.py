"""What a person may ask of the task: start, abort, release and reset."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from services.task.approach import Approach
from services.task.carry import Carry
from services.task.faults import Impairment, TaskFault
from services.task.fingers import Fingers
from services.task.geometry import steep
from services.task.grasp import grasp_doubts
from services.task.parameters import TaskParameters
from services.task.states import REACTIONS, Observation, State
from shared.messages import GripperState
from shared.parameters import Refused

ABORTED = "aborted: `start` carries on if the panel is held, `reset` begins anew"
_SAID_AGAIN = 0.5
"""Time [s] after which `release`, said again, is an answer to what the first one brought about, and no double click."""


class Commands(ABC):
    """The commands of the state machine: each is done, or refused with the reason and what to do instead."""

    state: State
    since: float
    reason: str
    ready: bool
    fingers: Fingers
    _settings: TaskParameters
    _approach: Approach | None
    _carry: Carry | None
    _aborted: bool
    _starting: bool
    _asked_at: float
    _seen: Observation | None
    _faults: Sequence[TaskFault]

    @abstractmethod
    def _go(self, state: State, reason: str, seen: Observation | None) -> None:
        """Enter a state."""

    def command(self, word: str) -> State:
        """Do what a person asks in one of the four words.

        Raises:
            Refused: with the reason and what to do instead.
        """
        {"start": self._start, "abort": self._abort, "release": self._release, "reset": self._reset}[word]()
        return self.state

    def _start(self) -> None:
        seen = self._known()
        if self.state is State.HOLDING and self.fingers.hold:
            if problem := self._why_not_on(seen):
                raise Refused(f"cannot carry on: {problem}")
            self._carry_from(seen)
            return self._go(State.CARRYING, "carrying on", seen)
        if self.state is not State.IDLE:
            instead = "`reset` first" if self.state in (State.HOLDING, State.DONE) else "it is at work already"
            raise Refused(f"start in state {self.state.value}: {instead}")
        if problem := self._settings.impossible():
            raise Refused(problem)
        self._refuse_if_stopped()
        if _gripper(seen).holding:
            raise Refused("the gripper holds something: `release` lets it go")
        self._open_idle(starting=True)

    def _why_not_on(self, seen: Observation) -> str:
        """Why the panel in the gripper cannot be carried on with, empty if it can."""
        blocking = [fault for fault in self._faults if fault.kind in REACTIONS[State.CARRYING]]
        if blocking:
            return blocking[0].sentence
        if not _gripper(seen).holding:
            return "the gripper holds nothing; `reset` begins anew"
        if self._carry is None and self._approach is None:
            return "nothing is known of how far the panel is turned; `release` lets it go"
        if self._carry is None and (doubts := grasp_doubts(seen.gripper, self._settings)):
            return f"the grasp failed: {', '.join(doubts)}; `release` lets go"
        return steep(seen.tool)

    def _abort(self) -> None:
        # An abort before it is ready must not be undone by what the journal says.
        self._aborted = not self.ready
        self._go(State.HOLDING, ABORTED, self._seen)

    def _release(self) -> None:
        seen = self._known()
        carry = self._carry
        if self.state is State.RELEASING and carry is not None:
            if not carry.asked:
                carry.asked, self._asked_at = True, self.since
            elif not carry.letting_go and self.since - self._asked_at >= _SAID_AGAIN:
                carry.let_go(seen)
        elif self.state is State.CARRYING or self._holds(seen):
            self._refuse_if_stopped()
            if self.state is not State.CARRYING or carry is None:
                self.fingers.close()
                carry = self._carry_from(seen)
            carry.asked, self._asked_at = True, 0.0
            self._go(State.RELEASING, "letting go as asked", seen)
        elif self.state is State.IDLE:
            self._refuse_if_stopped()
            self._open_idle(starting=False)
        else:
            raise Refused(f"release in state {self.state.value}: nothing is held")

    def _holds(self, seen: Observation) -> bool:
        """Whether there is something in the gripper that must not fall, whoever put it there."""
        if self.state is State.HOLDING:
            return self.fingers.hold
        return self.state is State.IDLE and seen.gripper is not None and seen.gripper.holding

    def _reset(self) -> None:
        if self.state not in (State.HOLDING, State.DONE, State.IDLE):
            raise Refused(f"reset in state {self.state.value}: `abort` first")
        gripper = self._known().gripper
        in_doubt = self.fingers.hold or not self.fingers.certain
        if in_doubt and (gripper is None or gripper.holding):
            raise Refused("the gripper holds something: `release` lets it go, `start` carries on")
        if self.fingers.hold:
            self.fingers.close(hold=False)
        self._approach, self._carry = None, None
        self._go(State.IDLE, "ready: `tandem task start`", self._seen)

    def _refuse_if_stopped(self) -> None:
        if stopped := self._stopped:
            raise Refused(stopped.sentence)

    @property
    def _stopped(self) -> TaskFault | None:
        return next((fault for fault in self._faults if fault.kind is Impairment.STOPPED), None)

    def _open_idle(self, starting: bool) -> None:
        self._starting, self.since = starting, 0.0
        self.fingers.open()

    def _carry_from(self, seen: Observation) -> Carry:
        """Carry on from where the tool is now, with what the robot carries and the same home.

        Somebody may have pulled the tool away meanwhile, while the base stood: the base brings the arm back.
        """
        before = self._carry
        home = seen.tool if before is None else before.home
        nominal = before.nominal if before else None
        self._carry = Carry(self._settings, self.fingers, home, float(seen.tool.position[2]), nominal)
        return self._carry

    def _known(self) -> Observation:
        if self._seen is None or not self.ready:
            raise Refused(f"not yet: {self.reason}")
        return self._seen


def _gripper(seen: Observation) -> GripperState:
    if seen.gripper is None:
        raise Refused(seen.unsure.sentence)
    return seen.gripper
