"""Whatever happens in whatever order: the gripper opens in idle and releasing only, and nothing old is approached."""

from __future__ import annotations

import contextlib

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from services.task.faults import FAULTS, Impairment, TaskFault
from services.task.states import Decision, State
from shared.parameters import Refused
from tests.services.task.rig import DT, ORDER, MachineRig
from tests.services.task.toy import MARKER

MOVED = 1e-6  # [m], [rad]
NOTICED, FADED = 0.4, 2.0
"""Time [s] that the gripper has said that it holds nothing after which the base stands, and nothing is nominal."""


class Anything(RuleBasedStateMachine):
    """Commands, faults, loss of everything, and time, in any order."""

    def __init__(self) -> None:
        super().__init__()
        self.play = MachineRig(search_patience=5.0, move_patience=10.0)
        self.before = self.play.state
        self.decision = Decision("none yet")
        self.doubtful = 0
        self.empty_for = 0.0
        self.lost = False

    def tick(self) -> None:
        play = self.play
        self.before = play.state
        blind = play.toy.marker is None
        play.changed = {**play.changed, "doubt": TaskFault("marker_missing") if blind else None}
        hidden = [TaskFault("marker_missing")] if blind else []
        faults, play.faults = play.faults, [*play.faults, *hidden]
        if "wrench" in play.changed:
            play.faults = [*play.faults, TaskFault("wrench_silent", "1 s old")]
        if self.lost:
            play.faults = [TaskFault("tool", "silent")]
        self.opening = play.toy.opening
        self.known = not self.lost and "gripper" not in play.changed
        if play.toy.gripped:
            self.empty_for = 0.0
        elif self.known:
            self.empty_for += DT
        self.decision = play.tick(self.lost)
        play.faults = faults
        self.check()

    def check(self) -> None:
        play, decision = self.play, self.decision
        if decision.gripper is not None and decision.gripper.opening > self.opening + MOVED:
            assert self.before in (State.IDLE, State.RELEASING), self.before
        if self.before is State.HOLDING and self.known:
            # The toy moves after the decision: what it was told is held against where it was then.
            assert play.toy.wanted <= self.opening + MOVED, "fingers go on opening"
        if self.before is State.APPROACHING and (play.toy.marker is None or self.lost):
            # What it wants now is where the tool was when the marker was lost.
            self.doubtful += 1
            if self.doubtful > 1 and decision.target is not None and self.anchor is not None:
                assert decision.target.near(self.anchor, MOVED, MOVED)
            self.anchor = decision.target
        else:
            self.doubtful, self.anchor = 0, None
        if decision.base:
            assert self.before is State.CARRYING and play.machine.fingers.hold
            assert self.known and self.empty_for < NOTICED
        if self.empty_for > FADED:
            assert decision.nominal == 0.0, play.state
        if any(fault.kind is Impairment.STOPPED for fault in play.faults) and not self.lost:
            assert play.state in (State.IDLE, State.DONE, State.HOLDING), play.state
        assert -play.settings.half_weight <= decision.nominal <= 0.0
        if play.machine.fingers.hold and decision.gripper is not None:
            assert decision.gripper.opening == 0.0

    @initialize(state=st.sampled_from(ORDER), lifted=st.booleans())
    def begin_in(self, state: State, lifted: bool) -> None:
        self.play.toy.lifted = lifted
        self.play.reach(state)

    @rule(steps=st.integers(1, 150))
    def time_passes(self, steps: int) -> None:
        for _ in range(steps):
            self.tick()

    @rule(steps=st.integers(1, 800))
    def goes_well(self, steps: int) -> None:
        """Everything works and the person does what the task waits for."""
        play, toy = self.play, self.play.toy
        play.faults, play.changed, toy.marker, self.lost = [], {}, MARKER, False
        for _ in range(steps):
            if play.state in (State.IDLE, State.DONE, State.HOLDING):
                self.tick()
                return
            if play.state is State.CARRYING:
                toy.lifted = True
                turned = abs(play.machine.rotation) > 1.5
                toy.roll_rate, toy.far_height = (0.0, toy.stands) if turned else (0.5, toy.far_height)
            self.tick()

    @rule(word=st.sampled_from(("start", "start", "start", "release", "reset", "abort")))
    def command(self, word: str) -> None:
        before, grip = self.play.state, self.play.machine.fingers.hold
        with contextlib.suppress(Refused):
            after = self.play.command(word)
            if word == "abort":
                assert after is State.HOLDING
            if word == "reset":
                assert after is State.IDLE and not (grip and self.play.toy.gripped)
            if word == "start":
                assert after in (State.IDLE, State.CARRYING) and before in (State.IDLE, State.HOLDING)

    @rule(name=st.sampled_from(sorted(FAULTS)))
    def fault(self, name: str) -> None:
        self.play.faults = [TaskFault(name)]

    @rule()
    def faults_end(self) -> None:
        self.play.faults, self.lost = [], False

    @rule(covered=st.booleans())
    def marker(self, covered: bool) -> None:
        self.play.toy.marker = None if covered else MARKER

    @rule(lost=st.booleans())
    def tool_pose(self, lost: bool) -> None:
        self.lost = lost

    @rule(known=st.sampled_from(("wrench", "gripper", "both")))
    def not_known(self, known: str) -> None:
        self.play.changed = {"wrench": {"wrench": None}, "gripper": {"gripper": None}, "both": {}}[known]

    @rule(rate=st.sampled_from((-0.3, 0.0, 0.3)), lifted=st.booleans(), far=st.sampled_from((None, 0.3, 0.8)))
    def person(self, rate: float, lifted: bool, far: float | None) -> None:
        self.play.toy.roll_rate, self.play.toy.lifted, self.play.toy.far_height = rate, lifted, far

    @rule(steps=st.integers(1, 150))
    def slips(self, steps: int) -> None:
        self.play.toy.slip()
        self.time_passes(steps)

    @invariant()
    def always_says_why(self) -> None:
        assert self.play.reason
        assert self.play.machine.since >= 0.0


Anything.TestCase.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)
TestAnything = Anything.TestCase
