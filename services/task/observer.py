"""From the newest messages to what the state machine observes, and to the faults that are present."""

from __future__ import annotations

import numpy as np

from services.task.faults import Impairment, TaskFault
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.states import UNSURE, Observation
from services.task.vision.sight import Sight
from shared import topics
from shared.clock import in_words, seconds
from shared.messages import Header
from shared.service import Inputs, Reading
from shared.topics import Topic
from shared.wire.subscription import PERIODS_TO_SILENCE, SLOWEST_PERIOD

GUARDED_MAX_AGE = 0.08
"""Age [s] of a control status up to which the base may follow, or three of its periods if that is more: with a step of
the task and one of the base, the base brakes 120 ms after the last command of a controller that is gone."""
STALE_SHARE = 0.9
"""Share [1] of the error bound above which the controller refuses a limit: above it a carry would not last."""
_REFUSED_ABOVE = 1.0 / 3.0  # [1] of the limit: what an error leaves of it has to exceed twice the error
_JUST_MEASURED = 10.0  # [s] of a zero's age up to which another one would tell no more
WRENCH_MAX_AGE = 0.2  # [s] up to which a wrench is used: decisions of the task take a second


class Observer:
    """Remembers what an observation depends on: the stop, the robot's session, the controller's period."""

    def __init__(self, parameters: TaskParameters) -> None:
        self._settings = parameters
        self._stop: str | None = None
        self._session: int | None = None
        self._status: Header | None = None
        self._period = 0.0

    def look(self, inputs: Inputs, sight: Sight) -> tuple[Observation, list[TaskFault]]:
        """What is known now, and what is wrong."""
        tool = inputs[topics.STATE_EE]
        doubt = _doubt(inputs, sight.tracker.doubt)
        faults = [
            fault
            for fault in (
                self._stopped(inputs),
                self._restarted(tool.header.session),
                *self._wrench(inputs),
                _controller(inputs),
                doubt,
            )
            if fault is not None
        ]
        wrench, gripper = inputs.get(topics.WRENCH_EXTERNAL), inputs.get(topics.STATE_GRIPPER)
        robot = inputs.get(topics.STATE_ROBOT)
        numb = any(fault.kind is Impairment.NUMB for fault in faults)
        unsure = _unsure(inputs)
        message = tool.message
        seen = Observation(
            tool=Pose.of(message.position, message.orientation),
            speed=float(np.linalg.norm(message.linear)),
            turning=float(np.linalg.norm(message.angular)),
            session=tool.header.session,
            wrench=None if numb or wrench is None else np.concatenate((wrench.message.force, wrench.message.torque)),
            gripper=None if unsure or gripper is None else gripper.message,
            unsure=unsure or UNSURE,
            marker=sight.tracker.pose,
            doubt=doubt or sight.proof.doubt,
            proven=sight.proof.proven,
            turn=sight.proof.turn,
            nudge=sight.nudge,
            guarded=self._guarded(inputs.get(topics.CONTROL_STATUS)),
            robot="" if robot is None or robot.age > topics.STATE_ROBOT.max_age else robot.message.reason,
        )
        return seen, faults

    def _stopped(self, inputs: Inputs) -> TaskFault | None:
        stop = inputs.get(topics.STOP)
        if stop is not None and stop.new:
            if stop.message.engaged:
                self._stop = stop.message.reason
            elif stop.header.valid:
                self._stop = None
        if self._stop is not None:
            return TaskFault("stop", self._stop)
        robot = inputs.get(topics.STATE_ROBOT)
        if robot is not None and robot.age <= topics.STATE_ROBOT.max_age and robot.message.mode == "stopped":
            return TaskFault("robot_stopped", robot.message.reason)
        return None

    def _restarted(self, session: int) -> TaskFault | None:
        before, self._session = self._session, session
        return TaskFault("robot_restarted") if before not in (None, session) else None

    def _wrench(self, inputs: Inputs) -> list[TaskFault]:
        reading = inputs.get(topics.WRENCH_EXTERNAL)
        if reading is None or reading.age > WRENCH_MAX_AGE:
            return [_missing("wrench", inputs, topics.WRENCH_EXTERNAL, WRENCH_MAX_AGE)]
        if not reading.header.valid or reading.message.fault:
            return [TaskFault("wrench_invalid", reading.message.fault)]
        if reading.message.compensation == "none":
            return [TaskFault("untared")]
        if reading.message.compensation == "tare" and self._settings.compensation == "payload":
            return [TaskFault("unidentified")]
        age, bound = reading.message.zero_age, reading.message.error_bound
        if age is None:
            return []
        if age < 0.0:
            return [TaskFault("no_zero")]
        limit = np.array(self._settings.force_limit + self._settings.torque_limit)
        if age > _JUST_MEASURED and (bound > STALE_SHARE * _REFUSED_ABOVE * limit).any():
            known = f"known to {bound[:3].max():.1f} N and {bound[3:].max():.2f} Nm only"
            return [TaskFault("zero_old", f"{in_words(age)} old and {known}")]
        return []

    def _guarded(self, reading: Reading | None) -> bool:
        if reading is None or reading.message.state not in ("tracking", "yielding"):
            return False
        before, self._status = self._status, reading.header
        sent = reading.header.seq - before.seq if before else 0
        if before is not None and before.session == reading.header.session and sent > 0:
            self._period = seconds(reading.header.stamp - before.stamp) / sent
        slowest = PERIODS_TO_SILENCE * min(self._period, SLOWEST_PERIOD)
        return reading.header.valid and reading.age <= max(GUARDED_MAX_AGE, slowest)


def _controller(inputs: Inputs) -> TaskFault | None:
    reading = inputs.get(topics.CONTROL_STATUS)
    if reading is None or reading.age > topics.CONTROL_STATUS.max_age:
        return _missing("controller", inputs, topics.CONTROL_STATUS, topics.CONTROL_STATUS.max_age)
    if reading.message.state == "braking":
        return TaskFault("controller_braking", reading.message.reason)
    who = inputs.taken(topics.CONTROL_TARGET)
    return TaskFault("target_taken", who) if who else None


def _doubt(inputs: Inputs, doubt: TaskFault | None) -> TaskFault | None:
    """Why there is no marker pose to trust: where no image is looked at, that may be since none fits."""
    refused = inputs.refused(topics.SENSOR_CAMERA)
    unseen = doubt is not None and doubt.name in ("camera_never", "camera_silent")
    return TaskFault("camera_refused", refused) if unseen and refused else doubt


def _unsure(inputs: Inputs) -> TaskFault | None:
    """Why it is not known what the gripper holds, if so."""
    reading, limit = inputs.get(topics.STATE_GRIPPER), topics.STATE_GRIPPER.max_age
    if reading is None or reading.age > limit:
        return _missing("gripper", inputs, topics.STATE_GRIPPER, limit)
    return None if reading.header.valid else TaskFault("gripper_invalid")


def _missing(what: str, inputs: Inputs, topic: Topic, limit: float) -> TaskFault:
    """That a topic is not there to be used: what comes is refused, nothing ever came, or it is too old."""
    if refused := inputs.refused(topic):
        return TaskFault(f"{what}_refused", refused)
    reading = inputs.get(topic)
    if reading is None:
        return TaskFault(f"{what}_never")
    return TaskFault(f"{what}_silent", f"{reading.age:.1f} s old, allowed are {limit:g} s")
