"""The state machine of the carrying task. It sees no clock, no bus and no image, and only the kinds of faults."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from services.task.approach import Approach
from services.task.carry import Carry
from services.task.commands import ABORTED, Commands
from services.task.faults import Impairment, TaskFault
from services.task.fingers import Fingers
from services.task.geometry import Pose, roll_since
from services.task.grasp import GraspWatch
from services.task.journal import JournalEntry, Resumption
from services.task.nominal_wrench import NominalWrench
from services.task.parameters import TaskParameters
from services.task.states import REACTIONS, WITH_PANEL, Decision, Observation, State, patience

_APPROACHES = {
    State.CALIBRATING: Approach.calibrate,
    State.SEARCHING: Approach.search,
    State.APPROACHING: Approach.approach,
    State.GRASPING: Approach.grasp,
}
_FIRST = "; before that: "
_CARRIES = {State.CARRYING: Carry.carry, State.RELEASING: Carry.release, State.RETREATING: Carry.retreat}


class StateMachine(Commands):
    """The states, and what a step in each does; the commands are those of ``Commands``.

    Attributes:
        state: of the task.
        since: time [s] in it.
        reason: one sentence: what it does or waits for.
        fingers: what the gripper is told; they open in ``releasing`` and ``idle`` only.
        ready: false until a restart has been judged by ``resume``.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self._settings = parameters
        self.state = State.IDLE
        self.since = 0.0
        self.reason = "waiting for the robot's state"
        self.fingers = Fingers(parameters)
        self.ready = False
        self._approach: Approach | None = None
        self._carry: Carry | None = None
        self._rest: Pose | None = None
        self._session = 0
        self._cause: TaskFault | None = None
        self._waited = 0.0
        self._asked_at = 0.0
        self._aborted = self._starting = False
        self._watch = GraspWatch()
        self._seen: Observation | None = None
        self._faults: Sequence[TaskFault] = ()

    def resume(self, recalled: Resumption, seen: Observation) -> None:
        """Begin where the last process stopped, as the journal says, or idle; never idle with a full gripper.

        After an abort that came first it holds, with what the journal says of the carry.
        """
        assert seen.gripper is not None
        self.ready, self._seen, self._session, entry = True, seen, seen.session, recalled.entry
        self.fingers.close(hold=seen.gripper.holding)
        if entry is not None:
            self._carry = self._recalled_carry(entry, entry.home_pose)
            self._go(State.CARRYING, "carrying on after a restart", seen)
        elif self.fingers.hold:
            kept = recalled.kept
            self._carry = self._recalled_carry(kept, seen.tool.rolled_as(kept.home_pose)) if kept else None
            what = recalled.reason or "no journal says what it is"
            remedy = "`start` or `release`" if kept else "`release` lets it go"
            self._go(State.HOLDING, f"the gripper holds something: {what}; {remedy}", seen)
        else:
            self._go(State.IDLE, recalled.reason or "ready: `tandem task start`", seen)
        if self._aborted:
            self._go(State.HOLDING, ABORTED, seen)

    def entry(self, target: Pose | None) -> JournalEntry | None:
        """What a restart has to know; None while nothing is held."""
        seen = self._seen
        if not self.fingers.hold or seen is None:
            return None
        carry = self._carry
        return JournalEntry(
            session=seen.session,
            state=self.state.value,
            home=(carry.home if carry else seen.tool).row,
            target=(target or seen.tool).row,
            mass=self._settings.panel_mass,
            nominal=carry.nominal.force if carry else 0.0,
            supported=carry.nominal.supported if carry else False,
        )

    @property
    def trouble(self) -> str:
        """The gravest fault that is present and concerns what is done now, in words; empty if none does."""
        concerned = REACTIONS.get(State.CARRYING if self.state is State.HOLDING else self.state, {})
        found = [fault for fault in self._faults if fault.kind in concerned]
        return min(found, key=lambda fault: list(Impairment).index(fault.kind)).sentence if found else ""

    @property
    def rotation(self) -> float:
        """Turn of the tool about its x axis since the grasp [rad]."""
        return roll_since(self._carry.home, self._seen.tool) if self._carry and self._seen else 0.0

    def step(self, seen: Observation | None, faults: Sequence[TaskFault], dt: float) -> Decision:
        """What one step decides.

        Args:
            seen: None if the tool's pose is not known.
            faults: all that are present.
            dt: time [s] since the last one.
        """
        self.since += dt
        if seen is not None:
            self.fingers.look(seen.gripper)
            if seen.session != self._session:
                # The tool must not go back to where it was in the robot's last run.
                self._session, self._rest = seen.session, seen.tool
        self._seen, self._faults = seen, self._with_grip(seen, faults, dt)
        decision = self._react(dt) or self._work(dt)
        self.reason = decision.reason
        if decision.after is not None:
            self._go(decision.after, decision.reason, seen)
        follows = decision.base and seen is not None and seen.guarded
        return replace(decision, base=follows, gripper=self.fingers.command)

    def _react(self, dt: float) -> Decision | None:
        """Stand still for a fault that concerns the state, and hold when it has lasted too long."""
        concerns = [(self._patience(fault.kind), fault) for fault in self._faults]
        serious = [(limit, fault) for limit, fault in concerns if limit is not None]
        if not serious:
            # Without the tool's pose there is nothing to compute; the last target stays.
            self._waited = 0.0
            return None if self._seen is not None else Decision(self.reason)
        limit, fault = min(serious, key=lambda pair: (pair[0], list(Impairment).index(pair[1].kind)))
        if self._waited == 0.0 or self._rest is None:
            # A pose not known when the waiting begins is taken as soon as it is: no old target is pursued meanwhile.
            self._rest = self._seen.tool if self._seen else None
        self._waited += dt
        if self._waited >= limit:
            self._cause = fault
            return Decision(fault.sentence, self._rest, self._nominal(), after=State.HOLDING)
        self._fade_if_loose(dt)
        head = None
        if self.state is State.CALIBRATING:
            head = (self._settings.head_pan, self._settings.head_tilt)
        way_out = "; `release` again opens at once" if self._asked else ""
        return Decision(f"waiting: {fault.sentence}{way_out}", self._rest, self._nominal(), head=head)

    def _patience(self, kind: Impairment) -> float | None:
        """Time [s] that is waited for a fault of a kind to go away; None if it does not matter now."""
        limit = patience(self.state, kind, self._settings)
        if self.state is not State.RELEASING or self._carry is None or kind in (Impairment.STOPPED, Impairment.LOST):
            return limit
        if self._carry.letting_go:
            # What has been let go cannot be held for a fault of what held it.
            return None
        if self._asked and limit is not None:
            # Otherwise a sensor that went wrong would keep the panel in the gripper for good.
            return None if kind is Impairment.LOOSE else math.inf
        return limit

    @property
    def _asked(self) -> bool:
        """Whether a person has said that the panel is to be let go."""
        return self.state is State.RELEASING and self._carry is not None and self._carry.asked

    def _work(self, dt: float) -> Decision:
        seen, approach, carry = self._seen, self._approach, self._carry
        assert seen is not None
        if self.state is State.IDLE:
            return self._idle(seen, dt)
        if self.state is State.DONE:
            return Decision(self.reason)
        if self.state is State.HOLDING:
            self._rest = self._rest or seen.tool
            self._fade_if_loose(dt)
            return Decision(self._why_held(), self._rest, self._nominal())
        if self.state in _APPROACHES:
            assert approach is not None
            return _APPROACHES[self.state](approach, seen, dt)
        assert carry is not None
        return _CARRIES[self.state](carry, seen, dt)

    def _why_held(self) -> str:
        """The reason as long as it lasts, then what to do."""
        if loose := self._loose:
            return loose.sentence
        cause = self._cause
        if cause is None or any(fault.name == cause.name for fault in self._faults):
            return self.reason
        self._cause = None
        remedy = "`start` carries on, `release` lets go" if self.fingers.hold else "`reset` begins anew"
        return f"{remedy}; it held because {cause.sentence.partition(': `')[0]}"

    def _idle(self, seen: Observation, dt: float) -> Decision:
        fingers = self.fingers
        if not fingers.opening:
            return Decision(self.reason.partition(_FIRST)[0] + self._wanting(seen))
        if stopped := self._stopped:
            fingers.stop(seen.gripper)
            cause = stopped.sentence.partition(": `")[0]
            return Decision(f"the opening was broken off ({cause}): ask for it again")
        if fingers.opened(seen.gripper, dt):
            if self._starting:
                return Decision("feeling whether the tool is free", seen.tool, after=State.CALIBRATING)
            return Decision("the gripper is open")
        if self.since > self._settings.grasp_patience:
            fingers.stop(seen.gripper)
            return Decision("the gripper does not open: look at it, then `start` again")
        return Decision("opening the gripper")

    def _wanting(self, seen: Observation) -> str:
        """What an idle robot whose tool is free may be asked for now, so that a start need not wait for it."""
        if seen.gripper is None or seen.gripper.holding:
            return ""
        wanted = (fault for fault in self._faults if fault.kind in (Impairment.UNTARED, Impairment.STALE))
        return next((_FIRST + fault.sentence for fault in wanted), "")

    def _go(self, state: State, reason: str, seen: Observation | None) -> None:
        before, self.state, self.since, self.reason, self._waited = self.state, state, 0.0, reason, 0.0
        self._cause = self._cause if state is State.HOLDING else None
        self._rest = seen.tool if seen else None
        self.fingers.stop(seen.gripper if seen else None)
        if state is State.CALIBRATING and seen is not None:
            self._approach, self._carry = Approach(self._settings, seen.tool), None
        elif state is State.GRASPING:
            self.fingers.close()
        elif state is State.CARRYING and before is State.GRASPING and seen is not None:
            self._carry = Carry(self._settings, self.fingers, seen.tool, float(seen.tool.position[2]))
        if self._approach is not None and seen is not None:
            self._approach.enter(seen.tool)

    def _recalled_carry(self, entry: JournalEntry, home: Pose) -> Carry:
        nominal = NominalWrench(self._settings.half_weight, entry.nominal, entry.supported)
        return Carry(self._settings, self.fingers, home, float(entry.target[2]), nominal)

    def _with_grip(self, seen: Observation | None, faults: Sequence[TaskFault], dt: float) -> Sequence[TaskFault]:
        """The faults, with those of the grip while the panel is held."""
        if self._carry is None or not self.fingers.hold or self.state not in WITH_PANEL:
            self._watch.forget()
            return faults
        grip = [TaskFault("slipped")] if self._watch.slipped(seen.gripper if seen else None, dt) else []
        if seen is not None and seen.gripper is None:
            grip.append(seen.unsure)
        return (*faults, *grip)

    @property
    def _loose(self) -> TaskFault | None:
        return next((fault for fault in self._faults if fault.kind is Impairment.LOOSE), None)

    def _fade_if_loose(self, dt: float) -> None:
        """The limits must not be centred on a weight that the tool does not carry any more."""
        if self._carry is not None and self._loose:
            self._carry.nominal.fade(dt)

    def _nominal(self) -> float:
        return self._carry.nominal.force if self._carry and self.fingers.hold else 0.0
