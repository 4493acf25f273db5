"""The certified law: force limits that hold between samples too, for every contact within the declared bounds.

``v = y + p - q`` with ``p, q >= 0``. Twelve directed rows bound what p, q and everything in flight can add to each
``|w_i|`` through Kbar; ``y`` is the yielding. Strict (``yield_start`` = 1) and rounded (< 1) differ in y and in the caps
(docs/guarantee.md, "The law").
"""

from __future__ import annotations

import math

import numpy as np

from services.controller.contact import StiffnessBound
from services.controller.law import Law, LawInput, Motion, narrow_limit
from services.controller.parameters import ControllerParameters
from services.controller.qp import TOLERANCE, UNBOUNDED, Qp, QpFailure, Timer, no_timer
from services.controller.yielding import RoundedYield, StrictYield, scaled_into
from shared.spatial import Array

_GAMMA = 12
_LYAPUNOV = 12
_CLOSED = 1e-7
"""A row with less room than this speed [m/s, rad/s] is closed: its variables are fixed at 0."""
_SHARE = 1.0 / 6.0
"""Share of what is left of V <= 1 that each axis may use in one command (rounded form)."""


class CertifiedLaw(Law):
    """The certified law in its strict and its rounded form."""

    name = "certified"

    def __init__(
        self, parameters: ControllerParameters, timer: Timer = no_timer, previous: Law | None = None
    ) -> None:
        super().__init__(parameters, timer, previous)
        T, d, tau = parameters.period, parameters.delay, parameters.lag
        self.rounded = parameters.yield_start < 1.0
        self.horizon = parameters.horizon
        self.response_time = self.horizon if self.rounded else self.horizon + T
        self.turn_in_flight = parameters.max_angular * T
        self.bound = StiffnessBound(parameters.contact_zones)
        self._strict = StrictYield()
        self._rounded = RoundedYield()
        # |v|^2 = |p - q|^2 + ...: with |p|^2 + |q|^2 instead no p_i and q_i oppose each other.
        self.qp = Qp(np.array([1.0] * 12 + [0.0]), 13, timer, T)
        self.qp.upper[_GAMMA] = UNBOUNDED
        self.qp.rows[_LYAPUNOV, _GAMMA] = -1.0
        self._scales = np.array([[1.0 / T], [1.0 / self.horizon]])
        self._version = -1
        self._M = np.zeros((12, 12))
        self._scaled = np.zeros((12, 12))
        self._per_row = np.ones(12)
        self._per_own = np.ones(12)
        self._y = np.zeros(6)
        self._y_path = np.zeros(12)
        self._w = np.zeros(12)
        self._cap = np.zeros(12)
        self._kept = np.zeros(12)
        self._levels = np.zeros((2, 12))
        self._now = np.zeros((2, 12))
        self._steady = np.zeros((2, 12))
        self._room = np.zeros(12)
        self._none = np.zeros(12)
        self._used = self._pq = self._inward = self._none

    @property
    def solve_us(self) -> float:
        return self.qp.solve_us

    def _refusal(self, state: LawInput) -> str | None:
        return super()._refusal(state) or narrow_limit(state.limit, self._error_bound(state))

    def _error_bound(self, state: LawInput) -> Array:
        return state.error_bound + self.box.inertial_force

    def _move(self, state: LawInput, error: Array, length: float, dt: float) -> Motion:
        eps = self._error_bound(state)
        W = state.limit - eps
        self._update_bound(state)
        cap = self._yield(state, W, eps, dt)
        closed = self._rows(state, W, eps, cap)
        y = self._y
        yields = bool(y.any())
        if yields and self.rounded and closed:
            # Retreat asks no row; nothing else may move while a row is closed.
            return Motion(y, np.sign(y), True)
        try:
            v, failure = self._solve(error, length, yields), None
        except QpFailure as problem:
            v, failure = y.copy(), self._recorded(problem)
        active, pressed = self._active(state, eps)
        return Motion(v, active, yields or pressed, failure)

    def _update_bound(self, state: LawInput) -> None:
        """Kbar for this attitude, and the rows ``M [p; q]`` with ``M = [L, Kbar; Kbar, L]``."""
        # F = wbar + |nominal force| bounds the sum of the contacts' forces where they do not squeeze.
        force = (state.limit[:3] + np.abs(state.nominal[:3])).tolist()
        turns = self.travel.in_flight.tolist()
        in_flight = max(turns[3] + turns[9], turns[4] + turns[10], turns[5] + turns[11])
        bound = self.bound
        bound.update(state.rotation, in_flight + self.turn_in_flight, force)
        if bound.version == self._version:
            return
        self._version = bound.version
        K, M = bound.matrix, self._M
        # up_i (w_i grows) counts q_i with d_i = Kbar_ii and p_i with low_i; down_i the other way round.
        M[:6, 6:] = M[6:, :6] = K
        M[:6, :6] = K
        np.fill_diagonal(M[:6, :6], bound.low)
        M[6:, 6:] = M[:6, :6]
        self._per_row = 1.0 / M.max(axis=1)
        self._scaled = M * self._per_row[:, None]
        self._per_own = 1.0 / np.tile(K.diagonal(), 2)
        self.qp.rows[:12, :12] = self._scaled

    def _yield(self, state: LawInput, W: Array, eps: Array, dt: float) -> Array:
        """Set y, scaled as a whole into the speed box; returns the caps (6,) of the rows."""
        w = state.wrench.tolist()
        wall = (state.limit + eps).tolist()
        bound, speed, D = self.bound, self.box.speed, self.response_time
        if not self.rounded:
            y, cap = self._strict.step(w, wall, bound, speed, D, dt), W
        else:
            rho = self.parameters.yield_start
            start, room = (rho * W).tolist(), ((1.0 - rho) * W).tolist()
            y = self._rounded.step(w, wall, start, room, bound, speed, D, dt)
            h = self._rounded.distance
            left = _SHARE * max(0.0, 1.0 - sum(value * value for value in h))
            # A_i = theta_i + X_i sqrt(h_i^2 + left/6): a box with rounded corners, V <= 1.
            cap = np.array([start[i] + room[i] * math.sqrt(h[i] * h[i] + left) for i in range(6)])
        if y is None:
            self._y[:] = 0.0
            self._y_path[:] = 0.0
            return cap
        # The direction of y is what it is proven for: never bent by a limit, only shortened.
        lower, upper = self.box.lower.tolist(), self.box.upper.tolist()
        self._y[:] = scaled_into(y, [upper[i] if y[i] > 0.0 else -lower[i] for i in range(6)])
        np.maximum(self._y, 0.0, out=self._y_path[:6])
        np.maximum(-self._y, 0.0, out=self._y_path[6:])
        return cap

    def _rows(self, state: LawInput, W: Array, eps: Array, cap: Array) -> bool:
        """Right-hand sides of all rows and the upper bounds of p and q; returns whether a row has no room at all.

        ``T M [p; q] <= max(0, A - (+-w) - M (s + T [y+; y-]))``. The same rows with ``T + d + tau`` for T and without s
        are the speed that can be kept up without ever being stopped by s; they only tighten the bound and make the
        approach smooth. The second level keeps the reserve: ``T d_i q_i <= max(0, ... - rho_i)``.
        """
        w, levels, now, steady = self._w, self._levels, self._now, self._steady
        w[:6] = state.wrench
        np.negative(state.wrench, out=w[6:])
        self._cap[:6] = self._cap[6:] = cap
        self._kept[:6] = self._kept[6:] = np.maximum(self.parameters.reserve * W, 3.0 * eps)
        np.subtract(self._cap, w, out=levels[0])
        np.subtract(levels[0], self._kept, out=levels[1])
        path = self.travel.in_flight + self.parameters.period * self._y_path
        np.subtract(levels, self._M @ path, out=now)
        now *= self._scales[0]
        np.multiply(levels, self._scales[1], out=steady)
        np.minimum(now, steady, out=now)
        closed = float(now[0].min()) <= 0.0
        np.maximum(now, 0.0, out=now)
        np.multiply(now[0], self._per_row, out=self._room)
        inward = now[1] * self._per_own
        upper = self.qp.upper
        # p_i lowers w_i: down_i; q_i raises it: up_i. The speed box leaves what y does not use.
        upper[:6] = np.minimum(inward[6:], self.box.upper - self._y)
        upper[6:12] = np.minimum(inward[:6], self._y - self.box.lower)
        self._inward = inward
        return closed

    def _solve(self, error: Array, length: float, yields: bool) -> Array:
        """v = y + p - q; whatever the solver answers, the rows hold."""
        qp, M, room, y = self.qp, self._scaled, self._room, self._y
        self._used, self._pq = self._none, self._none
        qp.right[:12] = room
        upper = qp.upper[:12]
        np.maximum(upper, 0.0, out=upper)
        shut = room < _CLOSED
        if shut.any():
            upper[(M[shut] > 0.0).any(axis=0)] = 0.0
            qp.right[:12][shut] = 1.0
        unit = self._unit_error(error, length)
        qp.rows[_LYAPUNOV, :6] = unit
        np.negative(unit, out=qp.rows[_LYAPUNOV, 6:12])
        decrease = -0.5 * self.parameters.lyapunov_rate * length
        if yields:
            # |y + p - q|^2 and e.(y + p - q), y given.
            qp.cost[:6] = 2.0 * y
            qp.cost[6:12] = -2.0 * y
            decrease -= float(unit.dot(y))
        else:
            qp.cost[:12] = 0.0
        qp.right[_LYAPUNOV] = decrease
        qp.cost[_GAMMA] = self.parameters.relaxation_weight * length
        pq = np.minimum(qp.solve()[:12], upper)
        np.maximum(pq, 0.0, out=pq)
        used = M @ pq
        # The feasible set is star-shaped about 0: shortening (p, q) until the rows hold keeps every one of them.
        factor = 1.0
        for use, have in zip(used.tolist(), room.tolist(), strict=True):
            if use * factor > have:
                factor = have / use
        pq *= factor
        self._used, self._pq = used * factor, pq
        return y + pq[:6] - pq[6:]

    def _active(self, state: LawInput, eps: Array) -> tuple[Array, bool]:
        """Which wrench limits bound the motion (6,), and whether one does so under load rather than as a precaution."""
        tight = (self._room - self._used) < TOLERANCE
        tight[:6] |= self._pq[6:] > self._inward[:6] - TOLERANCE
        tight[6:] |= self._pq[:6] > self._inward[6:] - TOLERANCE
        active = np.subtract(tight[:6], tight[6:], dtype=float)
        return active, bool((active * state.wrench > eps).any())
