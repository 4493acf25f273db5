"""The robot's side of the contract: what every robot process does with commands and stops, and what it tells of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shared.limits import Gate, GateLimits
from shared.messages import RobotStatus, TwistCommand
from shared.service import Inputs, Output, Reading
from shared.spatial import Array
from shared.topics import COMMAND_EE_TWIST, STATE_ROBOT, STOP, Topic

HOLDING_AFTER = 0.1
"""Time [s] without a fresh command after which the robot says that it holds: commands at 30 Hz with a ``ttl`` of 20 ms
would else change its mode sixty times a second."""
_INSTANT = 1e-9
"""Less time [s] than this is none."""


class RobotSide:
    """The gate with its inputs in front of it and ``state/robot`` behind it; simulation and bridges differ in neither.

    A robot process has ``INPUTS`` among the inputs of its wiring. In each step it calls ``take`` once, ``advance`` once
    or more often, and ``report`` once; where it brakes, ``hold``.

    Args:
        limits: of the gate.
        base_type: ``differential`` or ``omni``.
        simulated: whether there is no real robot.
        max_base: largest velocity (3,) of the base: vx, vy [m/s], wz [rad/s].
    """

    INPUTS: tuple[Topic, ...] = (COMMAND_EE_TWIST, STOP)

    def __init__(
        self, limits: GateLimits, base_type: str, simulated: bool, max_base: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> None:
        self.gate = Gate(limits)
        self._base_type = base_type
        self._simulated = simulated
        self._max_base = np.array(max_base)
        self._pending: Reading[TwistCommand] | None = None
        self._age = 0.0
        self._live = 0.0
        self._refusals: list[str] = []
        self._told = ""
        self._until_report = 0.0

    def take(self, inputs: Inputs, behind: float = 0.0) -> None:
        """Take over what is new: each command once, a stop at once.

        A stop engages whatever its publisher thinks of itself; only a valid message releases it.

        Args:
            inputs: of this step.
            behind: time [s] before now at which the next ``advance`` begins, for a process that goes through the time
                since its last step in several ones: a command acts from that one on in which it arrived.
        """
        stop = inputs.get(STOP)
        if stop is not None and stop.new and (stop.message.engaged or stop.header.valid):
            self.gate.stop(stop.message.engaged, stop.message.reason)
        command = inputs.get(COMMAND_EE_TWIST)
        if command is not None and (command.new or self._pending is not None):
            self._pending = command
            self._age = command.age - behind
        self._refusals = [f"{topic.key}: {text}" for topic in self.INPUTS if (text := inputs.refusals(topic))]

    def advance(self, dt: float) -> Array:
        """Twist (6,) [m/s, rad/s] to execute during the next ``dt`` [s]."""
        command = self._pending
        if command is not None and self._age > -_INSTANT:
            message = command.message
            self.gate.command(message.linear, message.angular, message.ttl, self._age, command.header.valid)
            self._pending = None
        self._age += dt
        self._live = HOLDING_AFTER if self.gate.mode == "ready" else self._live - dt
        return self.gate.advance(dt)

    @property
    def mode(self) -> str:
        """What ``state/robot`` says: ready, holding (for want of a fresh command, a while ago already) or stopped."""
        if self.gate.mode == "stopped":
            return "stopped"
        return "ready" if self._live > 0.0 else "holding"

    def report(self, dt: float, *reasons: str) -> list[Output]:
        """``state/robot`` if it is due: at its rate, and when the mode has changed.

        Args:
            dt: time [s] since the last call.
            reasons: why the robot does not move as commanded although the gate lets it; empty ones say nothing.
        """
        self._until_report -= dt
        mode = self.mode
        if mode == self._told and self._until_report > _INSTANT:
            return []
        counts = (
            (self.gate.clamped, "clamped"),
            (self.gate.expired, "expired"),
            (self.gate.late, "late"),
        )
        parts = (
            "" if mode == "ready" else self.gate.reason,
            *reasons,
            *(f"commands {what}: {count}" for count, what in counts if count),
            *self._refusals,
        )
        return [self._status(mode, "; ".join(part for part in parts if part))]

    def hold(self, reason: str) -> list[Output]:
        """Execute nothing until the next command, and say why: the process itself does not work."""
        self.gate.command(np.zeros(3), np.zeros(3), ttl=0.0, age=0.0, valid=False)
        self._pending, self._live = None, 0.0
        return [self._status(self.mode, reason)]

    def _status(self, mode: str, reason: str) -> Output:
        self._told = mode
        # Late by less than a period it keeps its rate, by more it does not catch up.
        period = 1.0 / STATE_ROBOT.rate
        self._until_report = (
            self._until_report + period if -period < self._until_report <= _INSTANT else period
        )
        limits = self.gate.limits
        status = RobotStatus(
            mode=mode,
            reason=reason,
            base_type=self._base_type,
            simulated=self._simulated,
            max_linear=limits.max_linear,
            max_angular=limits.max_angular,
            max_base=self._max_base,
        )
        return Output(STATE_ROBOT, status)
