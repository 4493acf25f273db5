"""When to send what a decision says: on change, and often enough that nobody takes the task for gone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.states import AT_REST, Decision, State
from shared import topics
from shared.messages import ControlTarget, Enable, HeadCommand
from shared.service import Output

_OFTEN = 0.15  # [s] between two targets, enables or statuses: 5 Hz or more, also if a step is late
_SELDOM = 0.4
"""Time [s] between two commands that repeat the last: less than half of the silence after which another participant may
command the gripper."""


class _Due:
    """Whether something is to be sent: it has changed, or was sent too long ago."""

    def __init__(self, every: float) -> None:
        self._every = every
        self._left = 0.0
        self._last: object = None

    def __call__(self, value: object, dt: float) -> bool:
        self._left -= dt
        if value == self._last and self._left > 1e-9:
            return False
        self._last, self._left = value, self._every
        return True


class Outbox:
    """Makes the commands of each step, and tells when a status is due.

    Attributes:
        target: the last one sent in the present activity; None before.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self._settings = parameters
        self.target: Pose | None = None
        self._nominal = 0.0
        self._target_due, self._base_due, self._status_due = _Due(_OFTEN), _Due(_OFTEN), _Due(_OFTEN)
        self._gripper_due, self._head_due = _Due(_SELDOM), _Due(_SELDOM)

    def commands(self, state: State, decision: Decision, dt: float) -> Iterator[Output]:
        """The commands that are due, the target first.

        Args:
            state: after the step.
            decision: of the step.
            dt: time [s] since the last one.
        """
        if state in AT_REST and decision.target is None:
            # Whoever wants the arm while the task rests shall have it.
            self.target = None
        elif decision.target is not None:
            self.target, self._nominal = decision.target, decision.nominal
        if self.target is not None:
            what = (self.target.position.tobytes(), self.target.rotation.tobytes(), self._nominal)
            if self._target_due(what, dt):
                yield Output(topics.CONTROL_TARGET, self._message(self.target))
        if self._base_due(decision.base, dt):
            yield Output(topics.BASE_ENABLE, Enable(decision.base))
        grip = decision.gripper
        if grip is not None and self._gripper_due((grip.opening, grip.effort), dt):
            yield Output(topics.COMMAND_GRIPPER, grip)
        if decision.head is not None and self._head_due(decision.head, dt):
            yield Output(topics.COMMAND_HEAD, HeadCommand(*decision.head))

    def status_due(self, state: State, dt: float) -> bool:
        """Whether ``task/status`` is to be sent, ``dt`` [s] after the last call: another reason alone is no change."""
        return self._status_due(state, dt)

    def _message(self, target: Pose) -> ControlTarget:
        return ControlTarget(
            target.position,
            target.orientation,
            np.array(self._settings.force_limit),
            np.array(self._settings.torque_limit),
            nominal_force=np.array((0.0, 0.0, self._nominal)),
        )
