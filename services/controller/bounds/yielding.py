"""Giving way: the part ``y`` of the twist that retreats from a wrench, whatever the target wants.

Both forms move down the gradient of the distance of the wrench from a box, which cannot raise that distance for any
passive contact (docs/guarantee.md, "Yielding"). ``StrictYield`` acts only beyond the limit, which at rest happens
only when that was lowered below what pressed already. ``RoundedYield`` begins earlier. As long as nothing proves that
the environment moves, the law keeps both within the rows.
"""

from __future__ import annotations

import math
import operator
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

from services.controller.bounds.caps import Caps
from services.controller.bounds.contact_softness import ContactSoftness
from services.controller.bounds.stiffness_bound import StiffnessBound
from shared.spatial import Array

Vector = Sequence[float]

_STOPPED = 1e-7
"""An integral slower than this [m/s, rad/s] has ended."""
_INTEGRAL_TIME = 4.0
"""Time constant of the integral in response times D; 2 oscillates at the largest stiffness, 4 decays."""
_FORGET_TIME = 2.0
"""Time constant, in response times D, with which the integral of an axis that is not pressed decays."""

_PATIENCE, _STUCK = 1.0, 0.1
"""After so long [s] with less than this share of the y that a load asks for which the nominal wrench carried, the
law gives way all the same."""

_NONE = (0.0,) * 6
_FOLLOWED = 1e-3
"""An integral slower than this [m/s, rad/s] follows nobody any more: the rows may have it back."""
_QUICKNESS = 1.5
"""Gain of following a moving environment over what settles in D at the stiffness that the contact shows."""
_ERRORS, _ROOM = 1.0, 0.05
"""Motion tells something of the contact if it can change the wrench by more than this many error bounds and this share
of the room above the box."""


@dataclass(slots=True)
class YieldInput:
    """What a form gives way to.

    Attributes:
        wrench: w (6,) [N, Nm].
        caps: where the form begins, and the wall that no measured wrench passes at rest.
        bound: Kbar.
        speed: (6,) [m/s, rad/s] that the integral saturates at.
        displacement: (6,) [m, rad] commanded since the last step.
        response_time: D [s].
        dt: [s] since the last step.
    """

    wrench: Vector
    caps: Caps
    bound: StiffnessBound
    speed: Vector
    displacement: Array
    response_time: float
    dt: float


def scaled_into(twist: list[float], speed: Vector) -> list[float]:
    """The twist (6,), shortened as a whole until no element exceeds ``speed`` (6,) [m/s, rad/s]."""
    factor = 1.0
    for value, limit in zip(twist, speed, strict=True):
        if abs(value) * factor > limit:
            factor = limit / abs(value)
    return twist if factor == 1.0 else [factor * value for value in twist]


def _unless_stopped(speed: float) -> float:
    return speed if abs(speed) > _STOPPED else 0.0


class _Integral:
    """Integral of a yielding velocity; lets a steady push be followed without a lasting excess."""

    def __init__(self) -> None:
        self.value = [0.0] * 6

    def add(self, y: Vector, state: YieldInput) -> list[float]:
        """``y`` (6,) plus its integral, which is carried on."""
        gain = state.dt / (_INTEGRAL_TIME * state.response_time)
        decay = self._decay(state.response_time, state.dt)
        kept = self.value
        for i in range(6):
            value = kept[i] + gain * y[i]
            if y[i] == 0.0 or value * state.wrench[i] < 0.0:
                value *= decay
            kept[i] = _unless_stopped(value)
        self.value = scaled_into(kept, state.speed)
        return [own + past for own, past in zip(y, self.value, strict=True)]

    def rest(self, response_time: float, dt: float) -> None:
        """Let ``dt`` [s] pass in which nothing yields."""
        decay = self._decay(response_time, dt)
        self.value = [_unless_stopped(decay * value) for value in self.value]

    @staticmethod
    def _decay(response_time: float, dt: float) -> float:
        return math.exp(-dt / (_FORGET_TIME * response_time))

    def slower_than(self, speed: float) -> bool:
        """Whether no element exceeds ``speed`` [m/s, rad/s]."""
        return max(map(abs, self.value)) < speed

    @property
    def at_rest(self) -> bool:
        return not any(self.value)


class Yielding(ABC):
    """One form of giving way.

    Attributes:
        moved: a measured wrench was beyond the wall, which proves that the environment moved, or the nominal wrench
            has moved away from a load that the rows do not let go; and the wrench has not come back into the box
            since: y is free of the rows.
    """

    def __init__(self) -> None:
        self._integral = _Integral()
        self.moved = False
        self._stuck = 0.0

    @property
    def at_rest(self) -> bool:
        """Whether nothing is left of what yielded before."""
        return not (self.moved or any(self._integral.value))

    @abstractmethod
    def step(self, state: YieldInput) -> list[float] | None:
        """Yielding velocity (6,) [m/s, rad/s], or None if there is none."""

    def brake(self, response_time: float, dt: float) -> None:
        """Let ``dt`` [s] pass at rest: what is left of the yielding must not move the tool after a long stop."""
        self._integral.rest(response_time, dt)
        if self._integral.slower_than(_FOLLOWED):
            self.moved = False  # a wrench beyond the wall will prove it again

    def left(self, share: float, shifted: bool, dt: float) -> None:
        """Take note of how much of y the rows have left, for ``dt`` [s].

        Whoever moves the nominal wrench away from a weight in hand wants it set down. Where another axis has no room
        neither would ever change: what has moved against the nominal wrench is treated as an environment that moves.
        """
        self._stuck = self._stuck + dt if shifted and share < _STUCK else 0.0
        self.moved = self.moved or self._stuck > _PATIENCE

    def _watch(self, state: YieldInput) -> None:
        self.moved = self.moved or any(map(operator.gt, map(abs, state.wrench), state.caps.wall))

    def _is_back(self, y: list[float] | None) -> bool:
        """Whether ``moved`` ends now, for the y (6,) that the box asks for."""
        back = self.moved and y is None and self._integral.slower_than(_FOLLOWED)
        self.moved = self.moved and not back
        return back


class StrictYield(Yielding):
    """Retreat in proportion to the excess over the limit plus its error bound.

    It begins at ``caps.threshold``, which is the wall, since a smaller measured wrench may still be within the limit;
    lower only where a limit is being lowered. The roots of Kbar are the scale, which keeps N/m and Nm/rad apart.
    """

    def step(self, state: YieldInput) -> list[float] | None:
        self._watch(state)
        bound = state.bound
        y = down_the_gradient(state.wrench, state.caps.threshold, bound.roots, bound, state.response_time)
        self._is_back(y)
        if y is None and self._integral.at_rest:
            return None
        return self._integral.add(y or _NONE, state)


class RoundedYield(Yielding):
    """Retreat from the box of ``yield_start`` limits.

    At rest the distance is measured in the room left above the box, which is what the rounded caps share out. Once the
    environment has moved it is measured in ``sqrt(Kbar_ii)``, in which no axis is much stiffer than another, and
    answered according to the stiffness that the contact shows (``ContactSoftness``): that follows faster. It stays so
    until the wrench is back in the box.

    Attributes:
        distance: h (6,), how far each axis is beyond its threshold, in units of the room left above it; V = |h|.
    """

    def __init__(self) -> None:
        super().__init__()
        self.distance = [0.0] * 6
        self._softness = ContactSoftness()

    def step(self, state: YieldInput) -> list[float] | None:
        w, caps, bound = state.wrench, state.caps, state.bound
        self.distance = [max(0.0, abs(w[i]) - caps.start[i]) / caps.room[i] for i in range(6)]
        self._watch(state)
        scale = bound.roots if self.moved or caps.lowering else caps.room
        y = down_the_gradient(w, caps.start, scale, bound, state.response_time)
        if self._is_back(y):
            self._softness = ContactSoftness()
        if y is None and self._integral.at_rest:
            return None
        if self.moved:
            gain = _QUICKNESS / self._share(state)
            y = [gain * value for value in y or _NONE]
        return self._integral.add(y or _NONE, state)

    def brake(self, response_time: float, dt: float) -> None:
        super().brake(response_time, dt)
        self._softness = ContactSoftness()

    def _share(self, state: YieldInput) -> float:
        """Share of the declared stiffness that the contact shows on the axes which are beyond the box."""
        pressed = [i for i in range(6) if self.distance[i] > 0.0] or range(6)
        bound, caps, scale = state.bound, state.caps, state.bound.roots
        hidden = _ERRORS * _norm(caps.errors, scale, pressed) + _ROOM * _norm(caps.room, scale, pressed)
        stiffest = bound.largest(pressed, scale)
        return self._softness.step(
            state.wrench, state.displacement, scale, stiffest, hidden, state.response_time, state.dt
        )


def _norm(values: Vector, scale: Vector, axes: Sequence[int]) -> float:
    return math.hypot(*(values[i] / scale[i] for i in axes))


def down_the_gradient(
    wrench: Vector, threshold: Vector, scale: Vector, bound: StiffnessBound, response_time: float
) -> list[float] | None:
    """``y_i = sign(w_i) max(0, |w_i| - threshold_i) / (scale_i^2 lambda_P D)`` (6,), or None if all are within.

    lambda_P is the largest eigenvalue of ``scale^-1 K scale^-1`` that a contact can have on the axes P which are beyond
    their thresholds, or which y would carry there: within D the squared distance then falls for any passive contact.
    """
    excess = [max(0.0, abs(wrench[i]) - threshold[i]) for i in range(6)]
    pressed = [i for i in range(6) if excess[i] > 0.0]
    if not pressed:
        return None
    slope = [math.copysign(excess[i] / scale[i] ** 2, wrench[i]) for i in range(6)]
    joined = list(pressed)
    while True:
        gain = 1.0 / (bound.largest(joined, scale) * response_time)
        y = [gain * value for value in slope]
        turned = [
            j
            for j in range(6)
            if j not in joined
            and response_time * sum(bound.rows[j][i] * abs(y[i]) for i in pressed) > threshold[j] - abs(wrench[j])
        ]
        if not turned:
            return y
        joined += turned
