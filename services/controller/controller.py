"""The controller service: one tool twist per external wrench."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np

from services.controller.bounds.caps import AXES, UNITS
from services.controller.laws import make_law
from services.controller.laws.law import LawInput, LawOutput
from services.controller.laws.qp import Timer, no_timer
from services.controller.parameters import ControllerParameters
from shared.faults import Fault
from shared.loop.halt import Halt
from shared.messages import ControlStatus, ControlTarget, EndEffector, ExternalWrench, TwistCommand
from shared.service import Inputs, Output, Service, Wiring
from shared.spatial import Array, rotation_matrix
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_PARAMETERS,
    CONTROL_STATUS,
    CONTROL_TARGET,
    STATE_EE,
    STOP,
    WRENCH_EXTERNAL,
)

_SHOWN_FOR = 10.0
"""Time [s] for which the health keeps showing a failed quadratic program."""
_ABSURD = 1e12
"""A margin [N, Nm] is reported down to this, so that a status can be sent whatever the inputs were."""
_SHARE, _TOO_RARE = 0.01, 1.1
"""Weight of one interval between samples in their mean, and mean in periods that is too long, whatever the jitter."""
_ZERO = np.zeros(6)


class Controller(Service[ControllerParameters]):
    """Keeps the wrench within the target's limits and otherwise the tool at the target's pose.

    A target stays in force when it falls silent, but not beyond a restart of the robot (a new session of ``state/ee``):
    what was received before is discarded, and the tool rests where it is until a target arrives.

    Args:
        parameters: checked parameters.
        timer: steady nanoseconds, for ``solve_us`` and the solver's time limit only.
    """

    wiring = Wiring(
        name="controller",
        driver=WRENCH_EXTERNAL,
        required=(WRENCH_EXTERNAL, STATE_EE),
        optional=(CONTROL_TARGET, STOP),
        parameters=CONTROL_PARAMETERS,
    )

    def __init__(self, parameters: ControllerParameters, timer: Timer = no_timer) -> None:
        super().__init__(parameters)
        # A message later than the fastest one by more than the declared delay proves that the delay is exceeded.
        self.max_delay = parameters.delay
        self._timer = timer
        self.law = make_law(parameters, timer)
        self._halt = Halt()
        self._target: ControlTarget | None = None
        self._robot_session: int | None = None
        self._restarted = False
        self._limit = self._nominal = _ZERO
        self._target_rotation = np.eye(3)
        self._refused = self._refused_before = ""
        self._settling = self._interval = 0.0
        self._measured = self._error_bound = _ZERO
        self._failures = 0
        self._show_failure = 0.0

    def step(self, inputs: Inputs, dt: float) -> Iterator[Output]:
        """The twist for the newest wrench, then the status."""
        self._listen(inputs)
        self._settling = max(0.0, self._settling - dt)
        self._show_failure = max(0.0, self._show_failure - dt)
        self._interval += _SHARE * (min(dt, 1.0) - self._interval)
        wrench, tool = inputs[WRENCH_EXTERNAL].message, inputs[STATE_EE].message
        measured = self._measured = np.concatenate((wrench.force, wrench.torque))
        self._error_bound = wrench.error_bound
        holding = self._holding()
        if holding is not None:
            return self._rest(*holding, dt)
        return self._decide(measured, wrench, tool, dt)

    def brake(self, fault: Fault, dt: float) -> Iterator[Output]:
        """A twist of zero, and why."""
        self._halt.fault(fault, dt)
        if self._halt.latched:
            return self._rest("braking", self._halt.latched, dt)
        return self._rest("waiting" if fault.waiting else "braking", fault.text, dt)

    def apply(self, parameters: ControllerParameters) -> None:
        """Take over parameters; if what is in flight was counted otherwise, it rests until that has acted."""
        before = self.parameters
        self.parameters = parameters
        self.max_delay = parameters.delay
        self.law = make_law(parameters, self._timer, previous=self.law)
        if parameters.premises != before.premises:
            self._settling = parameters.horizon + parameters.lag

    def notes(self) -> str:
        """Parameters without an effect, samples too rare, refused targets, the last failed program with its data."""
        notes = [ignored] if (ignored := self.parameters.ignored) else []
        if self._interval > _TOO_RARE * self.parameters.period:
            notes.append(
                f"{WRENCH_EXTERNAL.key} comes every {self._interval * 1e3:.0f} ms, period is "
                f"{self.parameters.period * 1e3:g} ms: each command ends before the next, so the tool moves in jerks; "
                "raise period or the sensor's rate"
            )
        if self._refused != self._refused_before:
            notes.append(f"{CONTROL_TARGET.key}: {self._refused}; the last valid one stays in force")
        if self._show_failure > 0.0 and self.law.last_failure is not None:
            data = json.dumps(self.law.last_failure, default=str)
            notes.append(f"{self._failures} ticks without an answer of the quadratic program, the last one: {data}")
        return "; ".join(notes)

    def _listen(self, inputs: Inputs) -> None:
        """Take in a new target or stop; forget the target if the robot has restarted."""
        self._halt.listen(inputs)
        self._refused = inputs.refusals(CONTROL_TARGET)
        target = inputs.get(CONTROL_TARGET)
        session = inputs[STATE_EE].header.session
        restarted = self._robot_session not in (None, session)
        self._robot_session = session
        if restarted:
            self._target, self._restarted = None, True
            self._limit = self._nominal = _ZERO
            self.law.start()
        if target is None or not target.new or not target.header.valid:
            return
        # The loop has watched the restarted robot for the whole start-up: what is older was meant for the one before.
        if restarted and target.age > self.wiring.startup:
            return
        self._restarted = False
        self._refused_before = self._refused
        self._target = target.message
        self._limit = np.concatenate((self._target.force_limit, self._target.torque_limit))
        self._nominal = np.concatenate((self._target.nominal_force, self._target.nominal_torque))
        self._target_rotation = rotation_matrix(self._target.orientation)

    def _holding(self) -> tuple[str, str] | None:
        """State and reason if the inputs are healthy but the tool has to rest all the same."""
        if reason := self._halt.reason:
            return "braking", reason
        if self._target is None:
            refused = f": {self._refused}" if self._refused else ""
            if self._restarted:
                return "waiting", f"robot restarted, a new {CONTROL_TARGET.key} is needed{refused}"
            return "waiting", f"no valid {CONTROL_TARGET.key} yet{refused}"
        if self._settling > 0.0:
            return "waiting", "law, timing or contacts were changed: resting until that holds for all that is in flight"
        return None

    def _decide(self, measured: Array, wrench: ExternalWrench, tool: EndEffector, dt: float) -> Iterator[Output]:
        assert self._target is not None
        output = self.law.step(
            LawInput(
                wrench=measured - self._nominal,
                limit=self._limit,
                error_bound=wrench.error_bound,
                position=tool.position,
                rotation=rotation_matrix(tool.orientation),
                target_position=self._target.position,
                target_rotation=self._target_rotation,
                nominal=self._nominal,
            ),
            dt,
        )
        refused = self._refused if self._refused != self._refused_before else ""
        if output.failure is None:
            return self._outputs(None, "; ".join(filter(None, (refused, self.law.remark, self._pending()))), output)
        if self.law.last_failure is not None and self.law.last_failure["reason"] == output.failure:
            self._failures += 1
            self._show_failure = _SHOWN_FOR
        # What gives way needs no solver: then it moves, and says so.
        return self._outputs(None if output.twist.any() else "braking", output.failure, output)

    def _pending(self) -> str:
        """Why limits are not the wished ones yet; empty if they are."""
        wished, in_force = self._limit, self.law.limit_in_force(self._limit, self._nominal)
        if in_force is wished:
            return ""
        axis = int(np.argmax(in_force / wished))
        unit, felt = UNITS[axis], self._measured[axis] - self._nominal[axis]
        return (
            f"limit {AXES[axis]}: {in_force[axis]:.3g} {unit} in force, {wished[axis]:.3g} wished; it is lowered as "
            f"what is felt ({felt:.3g} {unit}) and still in flight lets it"
        )

    def _rest(self, state: str, reason: str, dt: float) -> Iterator[Output]:
        self.law.brake(dt)
        return self._outputs(state, reason, LawOutput(_ZERO))

    def _outputs(self, state: str | None, reason: str, output: LawOutput) -> Iterator[Output]:
        """The command, then the status, made after the command has left; the law moves if ``state`` is None."""
        # The time to live is what makes T true: the robot drops a command that is older.
        twist = output.twist.tolist()
        yield Output(COMMAND_EE_TWIST, TwistCommand(twist[:3], twist[3:], ttl=self.parameters.period))
        # Of what was measured last; without a target there are no limits to count against.
        limit = self.law.limit_in_force(self._limit, self._nominal)
        margin = limit - np.abs(self._measured - self._nominal) - self._error_bound
        status = ControlStatus(
            state=state or ("yielding" if output.yielding else "tracking"),
            reason=reason,
            law=self.law.name,
            twist=twist,
            margin=_ZERO if self._target is None else np.maximum(margin, -_ABSURD),
            active=output.active,
            relaxation=output.relaxation,
            lyapunov=output.lyapunov,
            solve_us=self.law.solve_us,
            limit=limit,
            nominal=self._nominal,
        )
        yield Output(CONTROL_STATUS, status)
