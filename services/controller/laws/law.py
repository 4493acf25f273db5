"""What the three laws share: their inputs and outputs, the problem they solve, and how a tick ends safely.

All of them minimise ``|v|^2 + k gamma`` subject to ``e . v <= -(lambda/2)|e|^2 + gamma`` (Dawson et al., Eq. (9)),
where ``e`` is the pose error and ``v`` the tool twist. They differ in their bounds on ``v`` alone.
"""

from __future__ import annotations

import math
import operator
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from services.controller.bounds.travel_in_flight import TravelInFlight
from services.controller.laws.qp import TOLERANCE, Qp, QpFailure, Timer, no_timer
from services.controller.laws.speed_box import SpeedBox
from services.controller.parameters import ControllerParameters
from shared.spatial import Array, pose_error

_ABSURD = 1e150
"""A number of this size, or its square, cannot be calculated with."""
_AT_TARGET = 1e-7
"""Pose error [m, rad] below which the target is reached: the Lyapunov row says nothing, since its multiplier would be
lost in the solver's tolerances."""
_ZERO = np.zeros(6)
_UNBOUND = np.full(12, -np.inf)


@dataclass(slots=True)
class LawInput:
    """What a tick knows; all in base axes.

    Attributes:
        wrench: w (6,) [N, Nm] measured, less the nominal wrench.
        limit: wbar (6,) [N, Nm], > 0.
        error_bound: eps (6,) [N, Nm], bound on the error of ``wrench``.
        position: (3,) [m] of the tool's origin.
        rotation: (3, 3), tool to base.
        target_position: (3,) [m].
        target_rotation: (3, 3).
        nominal: (6,) [N, Nm] wrench that the tool carries by agreement.
    """

    wrench: Array
    limit: Array
    error_bound: Array
    position: Array
    rotation: Array
    target_position: Array
    target_rotation: Array
    nominal: Array = field(default_factory=lambda: _ZERO)


@dataclass(slots=True)
class LawOutput:
    """What a tick decided; what is only for the status is worked out when it is asked for, after the command.

    Attributes:
        twist: v (6,) [m/s, rad/s] to command.
        excess: (12,) [m/s, rad/s], 0 where a limit bounds the motion, negative where it leaves room for more; row i for
            the upper limit of w_i, row 6 + i for the lower one.
        retreats: the motion gives way to a wrench, whatever the target wants.
        failure: why the tick braked instead, or None.
        state: what it was decided for.
        error: e (6,) [m, rad] of the pose.
        lyapunov: V = |e|^2 / 2.
        lyapunov_rate: lambda [1/s].
    """

    twist: Array
    excess: Array = field(default_factory=lambda: _UNBOUND)
    retreats: bool = False
    failure: str | None = None
    state: LawInput | None = None
    error: Array = field(default_factory=lambda: _ZERO)
    lyapunov: float = 0.0
    lyapunov_rate: float = 0.0

    @property
    def active(self) -> Array:
        """(6,) 1 where the upper limit of the wrench's axis bounds the motion, -1 where the lower one does."""
        return np.array(self._active(), dtype=float)

    @property
    def yielding(self) -> bool:
        """It gives way to a wrench, or a limit bounds it under load rather than as a precaution."""
        if self.retreats or self.state is None:
            return self.retreats
        load = map(operator.mul, self._active(), self.state.wrench.tolist())
        return any(map(operator.gt, load, self.state.error_bound.tolist()))

    def _active(self) -> list[int]:
        bounds = [value >= -TOLERANCE for value in self.excess.tolist()]
        return [upper - lower for upper, lower in zip(bounds[:6], bounds[6:], strict=True)]

    @property
    def relaxation(self) -> float:
        """gamma, by how much the Lyapunov condition is relaxed."""
        return max(0.0, float(self.error.dot(self.twist)) + self.lyapunov_rate * self.lyapunov)


class Law(ABC):
    """One control law. Every call of ``step`` or ``brake`` must be followed by its twist being commanded.

    Args:
        parameters: of the controller.
        timer: steady nanoseconds, to measure the solver with.
        previous: the law that was in force so far, whose commands are still in flight.

    Attributes:
        qp: the quadratic program of a tick.
        twist: (6,) [m/s, rad/s] that was commanded last.
        remark: what the limits forbid that a person would expect, in words; empty if nothing.
    """

    name: str
    qp: Qp
    remark: str = ""

    def __init__(self, parameters: ControllerParameters, timer: Timer = no_timer, previous: Law | None = None) -> None:
        self.parameters = parameters
        self.speed_box = SpeedBox(parameters)
        self.last_failure: dict[str, Any] | None = None
        if previous is None:
            self.travel = TravelInFlight(parameters.period, parameters.delay, parameters.lag)
        else:
            self.last_failure = previous.last_failure
            self.travel = previous.travel
            self.travel.configure(parameters.period, parameters.delay, parameters.lag)
        self._rest = np.zeros(6)
        self.twist = self._rest

    @property
    def solve_us(self) -> float:
        """Time [us] of the last solve, 0 without a timer."""
        return self.qp.solve_us

    def step(self, state: LawInput, dt: float) -> LawOutput:
        """Decide the twist, ``dt`` [s] after the last call of ``step`` or ``brake``.

        Never raises for bad numbers and never returns any: what cannot be trusted ends in a twist that brakes, with
        the reason in ``failure``.
        """
        dt = dt if 0.0 <= dt < math.inf else 0.0
        self.travel.advance(dt)
        error = pose_error(state.position, state.rotation, state.target_position, state.target_rotation)
        square = float(error.dot(error))
        size = math.hypot(
            *state.wrench.tolist(), *state.limit.tolist(), *state.error_bound.tolist(), *state.nominal.tolist()
        )
        if not size + square < _ABSURD:  # nor if it is not a number
            return self._finish(LawOutput(self._rest, failure="an input is not finite"))
        self.speed_box.update(state.rotation, self.travel.speeds, dt)
        output = self._move(state, error, math.sqrt(square), dt)
        output.error, output.lyapunov = error, 0.5 * square
        output.lyapunov_rate = self.parameters.lyapunov_rate
        return self._finish(output)

    def brake(self, dt: float) -> None:
        """Account for a command of zero, ``dt`` [s] after the last call."""
        self.travel.advance(dt)
        self.travel.command(self._rest)
        self.twist = self._rest

    def start(self) -> None:  # noqa: B027 - most laws keep nothing
        """Begin anew, at rest: the robot is elsewhere, so what was promised there holds no more."""

    def limit_in_force(self, limit: Array, nominal: Array) -> Array:
        """What the wrench stays within (6,) [N, Nm] about the nominal one; the wished ``limit`` itself if that is so.

        Args:
            limit: (6,) wished; neither array is written to later: the same one is the same target.
            nominal: (6,) of the target.
        """
        return limit

    @abstractmethod
    def _move(self, state: LawInput, error: Array, length: float, dt: float) -> LawOutput:
        """The law's own part: a twist within the speed box; ``error`` (6,) has the norm ``length``."""

    def _recorded(self, failure: QpFailure) -> str:
        self.last_failure = {"reason": failure.reason, **failure.problem}
        return failure.reason

    def _finish(self, output: LawOutput) -> LawOutput:
        twist = self.speed_box.shortened(output.twist)
        if twist is None:
            output = LawOutput(self._rest, failure="the twist is not finite")
            twist = self._rest.copy()
        self.travel.command(twist)
        self.twist = output.twist = twist
        return output

    def _relax(self, length: float) -> float:
        """``1/length`` of the pose error, 0 at the target; sets bound and cost of the last variable accordingly.

        The variable is ``(gamma - (lambda/2)|e|^2)/|e|``: divided by the error's norm, the Lyapunov row
        ``(e/|e|).v - it <= 0``, ``it >= -(lambda/2)|e|``, is a speed like all other rows.
        """
        qp = self.qp
        if length > _AT_TARGET:
            qp.lower[-1] = -0.5 * self.parameters.lyapunov_rate * length
            qp.cost[-1] = self.parameters.relaxation_weight * length
            return 1.0 / length
        qp.lower[-1], qp.cost[-1] = 0.0, self.parameters.relaxation_weight
        return 0.0
