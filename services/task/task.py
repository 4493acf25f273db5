"""The task service: fifty steps of the state machine a second, and between them the search for the marker."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from services.task.faults import TaskFault
from services.task.grasp import SLIPPED_AFTER
from services.task.journal import Journal, boot_id, judge
from services.task.machine import StateMachine
from services.task.observer import Observer
from services.task.outbox import Outbox
from services.task.parameters import TaskParameters
from services.task.states import Decision, Observation, State
from services.task.timers import Sustained
from services.task.vision.sight import Sight
from shared import topics
from shared.faults import Fault, FaultKind
from shared.messages import Enable, MarkerPose, TaskStatus
from shared.parameters import Refused
from shared.requests import TaskAnswer, TaskCommand
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring

PERIOD = 0.02  # [s] of a step: the loops of level assist and nominal wrench change within tenths of seconds
JOURNALS = "task"  # folder of the journals, in that of a robot
_JOURNAL_EVERY = 1.0  # [s] between two entries, besides those at each change of state
_LOOKING = (State.SEARCHING, State.APPROACHING)
"""States that need the marker; in all others no image is looked at."""
_WATCHING = (State.CALIBRATING, *_LOOKING)
"""States in which the camera is subscribed to: it takes a moment until its first image is there."""


class Task(Service[TaskParameters]):
    """Runs the state machine on the newest messages.

    Args:
        parameters: checked parameters.
        now: steady clock [s], for the age of the journal only.
        folder: where the journal is kept; None keeps none.
    """

    def __init__(
        self, parameters: TaskParameters, now: Callable[[], float] = lambda: 0.0, folder: Path | None = None
    ) -> None:
        super().__init__(parameters)
        self.max_delay = parameters.max_delay
        self.wiring = Wiring(
            name="task",
            driver=PERIOD,
            required=(topics.STATE_EE,),
            optional=(
                topics.STATE_GRIPPER,
                topics.STATE_ROBOT,
                topics.WRENCH_EXTERNAL,
                topics.CONTROL_STATUS,
                topics.STOP,
            ),
            shares=(topics.CONTROL_TARGET,),
            occasional={topics.SENSOR_CAMERA: lambda: self.machine.state in _WATCHING},
            queries=(topics.TASK_COMMAND,),
            # An image takes half a period, more on a busy machine; a late step of the task harms nothing.
            overrun_share=1.0,
        )
        self._now = now
        self._boot = boot_id()
        self._folder = folder
        self._journal = Journal(folder / JOURNALS if folder else None, self._boot)
        self._lost = Sustained(SLIPPED_AFTER)
        self.machine = StateMachine(parameters)
        self._observer = Observer(parameters)
        self._sight = Sight(parameters)
        self._outbox = Outbox(parameters)
        self._height = 0.0
        self._session = 0
        self._journalled: object = None
        self._journal_due = 0.0

    def step(self, inputs: Inputs, dt: float) -> Iterator[Output]:
        """Commands, then status, then what takes time: the image and the journal."""
        self._sight.advance(dt)
        seen, faults = self._observer.look(inputs, self._sight)
        self._height = float(seen.tool.position[2])
        if not self.machine.ready and not self._resume(seen, dt):
            yield from self._outputs(Decision(self.machine.reason), dt)
            return
        self._session = seen.session
        yield from self._outputs(self.machine.step(seen, faults, dt), dt)
        self._look_for_marker(inputs)
        self._record(dt)

    def brake(self, fault: Fault, dt: float) -> Iterator[Output]:
        """The machine goes on without the tool's pose, and decides how long to wait for it."""
        if fault.kind is FaultKind.SHUTDOWN:
            # The last target stays in force and the gripper closed; only the base must not go on.
            yield Output(topics.BASE_ENABLE, Enable(False))
            return
        self._sight.advance(dt)
        name = "internal" if fault.kind is FaultKind.INTERNAL else "tool"
        decision = self.machine.step(None, [TaskFault(name, fault.text)], dt)
        if not self.machine.ready:
            decision = Decision(fault.text)
            self.machine.reason = fault.text
        yield from self._outputs(decision, dt)

    def query(self, query: topics.Query, request: Record, reply: Reply) -> None:
        """Answer ``task/command``.

        Raises:
            Refused: with the reason and what to do instead.
        """
        assert isinstance(request, TaskCommand)
        reply(TaskAnswer(self.machine.command(request.command).value))

    def apply(self, parameters: TaskParameters) -> None:
        """The parameters hold for the whole run.

        Raises:
            Refused: always.
        """
        raise Refused("the task's parameters are set at its start")

    def files(self) -> dict[str, str]:
        """The journal."""
        if self._folder is None:
            return {}
        session = self._session if self.machine.ready else None
        texts = self._journal.texts(session, self.machine.entry(self._outbox.target), self._now())
        return {f"{JOURNALS}/{name}": text for name, text in texts.items()}

    def notes(self) -> str:
        """What is wrong with what the task works with; else why a restart would not know of the carry, if so."""
        return self.machine.trouble or self._journal.problem

    def _resume(self, seen: Observation, dt: float) -> bool:
        """Begin, once it is known whether the gripper holds something; false before."""
        if seen.gripper is None:
            self.machine.reason = f"waiting: {seen.unsure.sentence}"
            return False
        entry = self._journal.read(seen.session)
        lost = entry is not None and entry.session == seen.session and not seen.gripper.holding
        if lost and not self._lost.update(True, dt):
            # What was held a moment ago is not given up for the word of a single sample.
            self.machine.reason = "waiting whether the gripper still holds the panel"
            return False
        recalled = judge(entry, self._journal.problem, seen, self.parameters, self._now(), self._boot)
        self.machine.resume(recalled, seen)
        if recalled.entry is not None:
            self._outbox.target = recalled.entry.target_pose
        return True

    def _outputs(self, decision: Decision, dt: float) -> Iterator[Output]:
        machine, pose = self.machine, self._sight.marker
        yield from self._outbox.commands(machine.state, decision, dt)
        if self._outbox.status_due(machine.state, dt):
            marker = MarkerPose(pose.position, pose.orientation, self._sight.tracker.age) if pose else None
            says = (machine.state.value, machine.since, machine.reason, machine.rotation, self._height, marker)
            yield Output(topics.TASK_STATUS, TaskStatus(*says))

    def _look_for_marker(self, inputs: Inputs) -> None:
        if self.machine.state not in _LOOKING:
            self._sight.reset()
            return
        reading = inputs.get(topics.SENSOR_CAMERA)
        if reading is not None and reading.new:
            self._sight.look(reading, inputs[topics.STATE_EE])

    def _record(self, dt: float) -> None:
        """Keep the journal: once a second while something is held, and whenever what matters has changed."""
        self._journal_due -= dt
        entry = self.machine.entry(self._outbox.target)
        # Half a newton is less than a person feels when the nominal wrench of a restart is off by that.
        what = None if entry is None else (entry.state, entry.supported, round(2.0 * entry.nominal))
        if what == self._journalled and (entry is None or self._journal_due > 0.0):
            return
        self._journalled, self._journal_due = what, _JOURNAL_EVERY
        self._journal.write(self._session, entry, self._now())
