"""The robot's side of the contract: what every robot process does with commands and stops, and what it tells of it."""

from __future__ import annotations

import re
from typing import Generic, TypeVar

import numpy as np

from shared.messages import BaseTwistCommand, GripperCommand, HeadCommand, RobotStatus, TwistCommand
from shared.robot.base_gate import BaseGate, BaseLimits
from shared.robot.gate import INSTANT, Gate, GateLimits
from shared.robot.held_command import HeldCommand, Ranges
from shared.schema.records import Record
from shared.service import Inputs, Output, Reading
from shared.spatial import Array
from shared.topics import (
    COMMAND_BASE_TWIST,
    COMMAND_EE_TWIST,
    COMMAND_GRIPPER,
    COMMAND_HEAD,
    OPERATOR_ENABLE,
    STATE_ROBOT,
    STOP,
    Topic,
)

M = TypeVar("M", bound=Record)
_COUNTED = re.compile(r": \d+( \(.*\))?$")

HOLDING_AFTER = 0.1
"""[s] Time without a fresh command after which the robot says that it holds: commands at 30 Hz with a ``ttl`` of 20 ms
would else change its mode sixty times a second. Motions broken off more shortly are counted, and told so much later
at most."""
NOT_ENABLED = "the enabling device is not pressed: hold a key in `tandem enable`"
"""Why nothing moves while the robot asks for an enabling device."""


class _Pending(Generic[M]):
    """The newest command of a topic, kept until the instant of its arrival is reached."""

    def __init__(self, topic: Topic[M]) -> None:
        self._topic = topic
        self._reading: Reading[M] | None = None
        self._age = 0.0

    def take(self, inputs: Inputs, behind: float) -> None:
        command = inputs.get(self._topic)
        if command is not None and (command.new or self._reading is not None):
            self._reading = command
            self._age = command.age - behind

    def due(self, dt: float) -> tuple[Reading[M], float] | None:
        """The command and its age [s], once, if it has arrived by now; then ``dt`` [s] pass."""
        age = self._age
        self._age += dt
        reading = self._reading
        if reading is None or age <= -INSTANT:
            return None
        self._reading = None
        return reading, age

    def drop(self) -> None:
        self._reading = None


class RobotSide:
    """The gates, with their inputs in front and ``state/robot`` behind them: the same for simulation and bridges.

    A robot process has ``INPUTS`` among the inputs of its wiring. In each step it calls ``take`` once, ``advance`` and
    ``advance_base`` once or more often, and ``report`` once; where it brakes, ``hold``.

    Attributes:
        gripper, head: the command to carry out that came with the last ``take``; None if none did.
        freeze: whether a stop was engaged with the last ``take``. Fingers and head stay where they are then, after its
            release too, until the next command; fingers that hold something, or close on it, close on it all the same,
            with no less effort: a stop must not let go of anything, and neither must its release.

    Args:
        limits: of the tool's gate.
        base_type: ``differential`` or ``omni``.
        simulated: whether there is no real robot.
        base: limits of the base's gate.
        gripper: ranges of ``opening`` [m] and ``effort`` [N].
        head: ranges of ``pan`` and ``tilt`` [rad].
        require_enable: whether nothing moves but while the enabling device is pressed.
    """

    INPUTS: tuple[Topic, ...] = (
        COMMAND_EE_TWIST,
        COMMAND_BASE_TWIST,
        COMMAND_GRIPPER,
        COMMAND_HEAD,
        STOP,
        OPERATOR_ENABLE,
    )

    def __init__(
        self,
        limits: GateLimits,
        base_type: str,
        simulated: bool,
        base: BaseLimits,
        gripper: Ranges,
        head: Ranges,
        require_enable: bool = False,
    ) -> None:
        self.gate = Gate(limits)
        self.base_gate = BaseGate(base)
        self._base_type = base_type
        self._simulated = simulated
        self._require_enable = require_enable
        self._enabled = not require_enable
        self._pending: _Pending[TwistCommand] = _Pending(COMMAND_EE_TWIST)
        self._pending_base: _Pending[BaseTwistCommand] = _Pending(COMMAND_BASE_TWIST)
        self._gripper, self._head = HeldCommand(COMMAND_GRIPPER, gripper), HeldCommand(COMMAND_HEAD, head)
        self.gripper: GripperCommand | None = None
        self.head: HeadCommand | None = None
        self.freeze = False
        self._live = 0.0
        self._refusals: list[str] = []
        self._cut_off = ""
        self._unlinked = False
        self._told = ""
        self._told_held = 0
        self._until_report = 0.0

    def take(self, inputs: Inputs, behind: float = 0.0, pressed: bool = False, releasable: bool = True) -> None:
        """Take over what is new: each command once, a stop at once.

        A stop engages whatever its publisher thinks of itself; only a valid message releases it. What is asked of
        gripper and head meanwhile is refused for good: nothing moves at a release but what is commanded after it.
        While nobody could stop the robot, arm and base execute nothing. While an enabling device is required and not
        pressed, nothing does: as at a stop, but it goes on when the device is pressed.

        Args:
            inputs: of this step.
            behind: time [s] before now at which the next ``advance`` begins, for a process that goes through the time
                since its last step in several ones: a command acts from that one on in which it arrived.
            pressed: whether an enabling device of the robot's own is pressed.
            releasable: whether a release counts that comes now.
        """
        stop, before = inputs.get(STOP), self.mode
        if stop is not None and stop.new and (stop.message.engaged or (stop.header.valid and releasable)):
            self.gate.stop(stop.message.engaged, stop.message.reason)
            self.base_gate.stop(stop.message.engaged)
        self._pending.take(inputs, behind)
        self._pending_base.take(inputs, behind)
        allowed, self._enabled = self._enabled, not self._require_enable or pressed or self._pressed(inputs)
        self._cut_off = inputs.cut_off
        self._unlinked = inputs.links.get(COMMAND_EE_TWIST.publisher) is False
        if self._cut_off or not self._enabled:
            self._command_nothing()
        self.freeze = (self.mode == "stopped" and before != "stopped") or (allowed and not self._enabled)
        # What comes in one step with a release may have been given before it.
        stopped = "stopped" in (before, self.mode) or not (allowed and self._enabled)
        self.gripper, self.head = self._gripper.take(inputs, stopped), self._head.take(inputs, stopped)
        self._refusals = [f"{topic.key}: {text}" for topic in self.INPUTS if (text := inputs.refusals(topic))]

    def _pressed(self, inputs: Inputs) -> bool:
        """Whether the enabling device is pressed, by its newest word; silence means that it is let go."""
        device = inputs.get(OPERATOR_ENABLE)
        if device is None or device.age > OPERATOR_ENABLE.max_age:
            return False
        return device.message.pressed and device.header.valid

    def advance(self, dt: float) -> Array:
        """Twist (6,) [m/s, rad/s] of the tool to execute during the next ``dt`` [s]."""
        due = self._pending.due(dt)
        if due is not None:
            command, age = due
            message = command.message
            self.gate.command(message.linear, message.angular, message.ttl, age, command.header.valid)
        self._live = HOLDING_AFTER if self.gate.mode == "ready" else self._live - dt
        return self.gate.advance(dt)

    def advance_base(self, dt: float) -> Array:
        """Velocity (3,) vx, vy [m/s], wz [rad/s] of the base to execute during the next ``dt`` [s]."""
        due = self._pending_base.due(dt)
        if due is not None:
            command, age = due
            self.base_gate.command(command.message.velocity, command.message.ttl, age, command.header.valid)
        return self.base_gate.advance(dt)

    @property
    def mode(self) -> str:
        """Mode in ``state/robot``: ready, holding (for want of a fresh command, a while ago already) or stopped."""
        if self.gate.mode == "stopped":
            return "stopped"
        return "ready" if self._live > 0.0 else "holding"

    def report(self, dt: float, *reasons: str) -> list[Output]:
        """``state/robot`` if it is due: at its rate, and when the mode has changed or a motion was broken off.

        Args:
            dt: time [s] since the last call.
            reasons: why the robot does not move as commanded although the gate lets it; empty ones say nothing.
        """
        self._until_report -= dt
        mode = self.mode
        news = (
            self.gate.held != self._told_held and self._until_report <= 1.0 / STATE_ROBOT.rate - HOLDING_AFTER + INSTANT
        )
        if mode == self._told and not news and self._until_report > INSTANT:
            return []
        gate, base = self.gate, self.base_gate
        parts = (
            self._cut_off and f"nobody could stop the robot: {self._cut_off}",
            "" if self._enabled else NOT_ENABLED,
            "" if mode == "ready" else gate.reason,
            f"no direct link to {COMMAND_EE_TWIST.publisher}" if mode == "holding" and self._unlinked else "",
            *reasons,
            _counted(gate.clamped, "commands clamped"),
            _counted(gate.expired, "commands expired"),
            _counted(gate.late, "commands late"),
            _counted(base.clamped, "base commands clamped", f"last: {base.clamped_by}"),
            _counted(base.expired, "base commands expired"),
            _counted(base.late, "base commands late"),
            *(_counted(*row) for row in (*self._gripper.counts, *self._head.counts)),
            *self._refusals,
        )
        return [self._status(mode, "; ".join(part for part in parts if part))]

    def hold(self, reason: str) -> list[Output]:
        """Execute nothing until the next command, and say why: the process itself does not work."""
        self._command_nothing()
        self._live = 0.0
        return [self._status(self.mode, reason)]

    def _command_nothing(self) -> None:
        self.gate.command(np.zeros(3), np.zeros(3), ttl=0.0, age=0.0, valid=False)
        self.base_gate.command(np.zeros(3), ttl=0.0, age=0.0, valid=False)
        self._pending.drop()
        self._pending_base.drop()

    def _status(self, mode: str, reason: str) -> Output:
        self._told, self._told_held = mode, self.gate.held
        # Late by less than a period it keeps its rate, by more it does not catch up.
        period = 1.0 / STATE_ROBOT.rate
        self._until_report = self._until_report + period if -period < self._until_report <= INSTANT else period
        limits = self.gate.limits
        status = RobotStatus(
            mode=mode,
            reason=reason,
            base_type=self._base_type,
            simulated=self._simulated,
            max_linear=limits.max_linear,
            max_angular=limits.max_angular,
            max_base=self.base_gate.limits.largest,
            held=self.gate.held,
            require_enable=self._require_enable,
        )
        return Output(STATE_ROBOT, status)


def _counted(count: int, what: str, more: str = "") -> str:
    return f"{what}: {count}{more and f' ({more})'}" if count else ""


def at_present(reason: str) -> str:
    """What of the ``reason`` in ``state/robot`` holds now: all but what was counted since the process began."""
    return "; ".join(part for part in reason.split("; ") if not _COUNTED.search(part))
