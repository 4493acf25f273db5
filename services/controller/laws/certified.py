"""The certified law: force limits that hold between samples too, for every contact within the declared bounds.

``v = y + p - q`` with ``p, q >= 0``. Twelve directed rows bound what p, q and everything in flight can add to each
``|w_i|`` through Kbar; ``y`` is the yielding, which keeps the same rows unless the environment has moved. Strict
(``yield_start`` = 1) and rounded (< 1) differ in where y begins and in the caps (docs/guarantee.md, "The law").

Twelve-vectors run over the directions of ``TravelInFlight``: element i is motion that makes w_i grow (q_i), element
6 + i motion that makes it fall (p_i); row i keeps w_i below its cap, row 6 + i keeps -w_i below it.
"""

from __future__ import annotations

import operator

import numpy as np

from services.controller.bounds.caps import Caps
from services.controller.bounds.stiffness_bound import StiffnessBound
from services.controller.bounds.travel_in_flight import SENSES
from services.controller.bounds.yielding import RoundedYield, StrictYield, Yielding, YieldInput, scaled_into
from services.controller.laws.law import Law, LawInput, LawOutput
from services.controller.laws.qp import CLOSED, UNBOUNDED, Qp, QpFailure, Timer, no_timer
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

_GAMMA = 12
_LYAPUNOV = 12
_ZERO = np.zeros(12)
_NO_ROOM = np.zeros(36)


class CertifiedLaw(Law):
    """The certified law in its strict and its rounded form."""

    name = "certified"

    def __init__(
        self, parameters: ControllerParameters, timer: Timer = no_timer, previous: Law | None = None
    ) -> None:
        super().__init__(parameters, timer, previous)
        T = parameters.period
        self.rounded = parameters.yield_start < 1.0
        # D: from a wrench to the full answer to it; the strict form counts one more period.
        self.response_time = parameters.horizon if self.rounded else parameters.horizon + T
        self.bound = StiffnessBound(parameters.contact_zones)
        self._turn_of_command = parameters.max_angular * T
        self.caps = Caps(parameters.reserve, parameters.yield_start)
        self._yielding: Yielding = RoundedYield() if self.rounded else StrictYield()
        # |p|^2 + |q|^2 in place of |p - q|^2: the same minimum without p_i and q_i opposing each other.
        self.qp = Qp(np.array([1.0] * 12 + [0.0]), 13, timer, T)
        self.qp.upper[_GAMMA] = UNBOUNDED
        self.qp.rows[_LYAPUNOV, _GAMMA] = -1.0
        self._version = -1
        self._M = np.zeros((12, 12))
        self._scaled = np.zeros((12, 12))
        # Rooms as speeds, of the next period, lasting, and lasting with the reserve: per_force times what the caps
        # leave of [w; path], in one product with [w; path; 1].
        self._rates = 1.0 / np.array((T, parameters.horizon, parameters.horizon)).reshape((3, 1, 1))
        self._largest = np.zeros((3, 1, 6))
        self._per_force = np.zeros((3, 12))
        self._room_matrix = np.zeros((36, 19))
        self._load = np.ones(19)
        self._path = self._load[6:18]
        self._rooms = np.zeros((3, 12))
        self._flat_rooms = self._rooms.ravel()
        self._opened = np.zeros((2, 12))  # how far the lasting rooms are in use
        self._change, self._part = np.zeros((2, 12)), np.zeros((2, 12))
        self._started = False
        self._levels: Array | None = None  # those that the offset was made for
        self._tightest = 0.0
        self._y = np.zeros(6)
        self._y_speeds = np.zeros(12)
        self._room = np.zeros(12)
        # Views of arrays that are written in place.
        flat, matrix = self._M.ravel(), self._room_matrix.reshape((3, 12 * 19))
        self._each_sense = self._M.reshape((2, 6, 2, 6))
        self._along = flat[6:72:13], flat[72::13]  # row i by motion along +i, row 6 + i by motion along -i
        self._of_force = matrix[..., : 6 * 19 : 20], matrix[..., 6 * 19 :: 20]  # row i and row 6 + i by w_i
        matrix = self._room_matrix.reshape((3, 12, 19))
        self._of_path, self._offset = matrix[0, :, 6:18], matrix[..., 18]
        self._next, self._lasting = self._rooms[0], self._rooms[1:]
        self._usable, self._reserved = self._opened
        self._excess, self._upper, self._right = self.qp.excess[:12], self.qp.upper[:12], self.qp.right[:12]
        self._pull = self.qp.cost[:12]
        self._lyapunov = self.qp.rows[_LYAPUNOV, :12]

    @property
    def solve_us(self) -> float:
        return self.qp.solve_us

    def brake(self, dt: float) -> None:
        super().brake(dt)
        self._yielding.brake(self.response_time, dt)

    def _move(self, state: LawInput, error: Array, length: float, dt: float) -> LawOutput:
        error_bound = state.error_bound
        if self.speed_box.payload:
            error_bound = error_bound + self.speed_box.inertial_force
        self.caps.update(state.limit, error_bound)
        if self.caps.refusal is not None:
            return LawOutput(self._rest, failure=self.caps.refusal)
        self._update_bound(state)
        yields = self._yield(state, dt)
        closed = self._rows(state, yields, dt)
        y = self._y
        if yields and self.rounded and closed:
            # Nothing but the retreat may move while a row has no room.
            return LawOutput(y, np.where(np.concatenate((y, -y)) > 0.0, 0.0, -np.inf), retreats=True)
        try:
            speeds, failure = self._solve(error, length, yields), None
        except QpFailure as problem:
            speeds, failure = _ZERO, self._recorded(problem)  # y alone needs no solver
            self._excess.fill(0.0)
        v = speeds[6:] - speeds[:6]
        if yields:
            v += y
        excess = np.maximum(self._excess, speeds - self._reserved)
        return LawOutput(v, excess, yields, failure, state)

    def _update_bound(self, state: LawInput) -> None:
        """Kbar for this attitude, and the rows' matrix ``M = [Kbar, L; L, Kbar]``."""
        # F = wbar + |nominal force| bounds the sum of the contacts' forces where they do not squeeze.
        x, y, z = self.caps.force
        nx, ny, nz = state.nominal.tolist()[:3]
        force = [x + abs(nx), y + abs(ny), z + abs(nz)]
        turns = self.travel.in_flight.tolist()
        in_flight = max(turns[3] + turns[9], turns[4] + turns[10], turns[5] + turns[11])
        bound = self.bound
        bound.update(state.rotation, in_flight + self._turn_of_command, force)
        if bound.version == self._version:
            return
        self._version = bound.version
        # Row i counts motion against its own axis with d_i = Kbar_ii, along it with low_i, all else with Kbar.
        M, K = self._M, bound.matrix
        self._each_sense[:] = K[:, None]
        for along in self._along:
            along[:] = bound.low
        # Both kinds of rows as speeds: a general row divided by its largest element (low_i <= Kbar_ii), a reserve row
        # by its only one.
        largest, per_force = self._largest, self._per_force
        largest[:2], largest[2] = [max(row) for row in bound.rows], K.diagonal()
        np.divide(self._rates, largest, out=per_force.reshape((3, 2, 6)))
        growing, falling = self._of_force
        against = -per_force
        growing[:], falling[:] = against[..., :6], per_force[..., 6:]
        np.multiply(against[0][:, None], M, out=self._of_path)  # what is in flight stops no lasting speed
        self._levels = None
        np.divide(M.reshape((2, 6, 12)), largest[0].T, out=self._scaled.reshape((2, 6, 12)))
        self.qp.rows[:12, :12] = self._scaled

    def _yield(self, state: LawInput, dt: float) -> bool:
        """Set y, scaled as a whole into the speed box; returns whether there is any."""
        w, caps = state.wrench.tolist(), self.caps
        y = None
        if not self._yielding.at_rest or any(map(operator.gt, map(abs, w), caps.threshold)):
            displacement = min(dt, self.parameters.period) * self.twist
            y = self._yielding.step(
                YieldInput(w, caps, self.bound, self.speed_box.speed, displacement, self.response_time, dt)
            )
        if y is None:
            self._y.fill(0.0)
            return False
        reach = self.speed_box.reach
        if self._yielding.moved:
            np.clip(y, -reach[:6], reach[6:], out=self._y)
        else:  # shortened as a whole, it still goes down the gradient
            free = reach.tolist()
            self._y[:] = scaled_into(y, [free[6 + i] if y[i] > 0.0 else free[i] for i in range(6)])
        np.negative(self._y, out=self._y_speeds[:6])
        self._y_speeds[6:] = self._y
        np.maximum(self._y_speeds, 0.0, out=self._y_speeds)
        if not self._yielding.moved:
            self._keep_rows(state)
        return bool(self._y_speeds.any())

    def _keep_rows(self, state: LawInput) -> None:
        """Shorten y to ``T M y <= max(0, C - (+-w) - M s)``: with that, at rest, y can carry no axis over its limit."""
        most, w, speeds = self.caps.most, state.wrench.tolist(), self._y_speeds
        room = np.array([most[i] - w[i] for i in range(6)] + [most[i] + w[i] for i in range(6)])
        room -= np.dot(self._M, self.travel.in_flight)
        shut = room <= 0.0
        if shut.any():
            speeds[(self._M[shut] > 0.0).any(axis=0)] = 0.0
        used = self.parameters.period * np.dot(self._M, speeds)
        if (used > np.maximum(room, 0.0)).any():
            speeds *= min(
                have / use for use, have in zip(used.tolist(), room.tolist(), strict=True) if use > have > 0.0
            )
        np.subtract(speeds[6:], speeds[:6], out=self._y)

    def _rows(self, state: LawInput, yields: bool, dt: float) -> bool:
        """Room of every row as a speed, and the upper bounds of q and p; returns whether a row has none at all.

        ``T M [q; p] <= max(0, A - (+-w) - M (s + T y))``. The same with ``T + d + tau`` for T and without s is the
        speed that can be kept up without being stopped by s later; taking the smaller of both only tightens the rows
        and makes an approach smooth. The reserve, ``(T + d + tau) d_i q_i <= max(0, A_i - (+-w_i) - rho_i)``, is of
        this kind alone: with s in it, motions would take turns. Room that has come back is used little by little, over
        a response time: taken at once, it would be gone again before the wrench shows it, and the tool would hunt.
        """
        load, room = self._load, self._room
        load[:6] = state.wrench
        path = self._path
        path[:] = self.travel.in_flight
        levels = self.caps.levels
        if yields:
            path += self.parameters.period * self._y_speeds
            if isinstance(self._yielding, RoundedYield):
                levels = self.caps.levels_at(self._yielding.distance)
        if levels is not self._levels:
            np.multiply(self._per_force, levels, out=self._offset)
            self._levels = None if yields else levels
        self._room_matrix.dot(load, self._flat_rooms)
        np.maximum(self._flat_rooms, _NO_ROOM, out=self._flat_rooms)
        opened, change, part = self._opened, self._change, self._part
        np.subtract(self._lasting, opened, out=change)
        np.multiply(change, min(1.0, dt / self.parameters.horizon) if self._started else 1.0, out=part)
        self._started = True
        np.minimum(change, part, out=change)  # shut at once, opened by a part
        opened += change
        np.minimum(self._next, self._usable, out=room)
        self._tightest = min(room.tolist())
        upper = self._upper
        if yields:  # the speed box leaves what y does not use; y against a direction frees none of it
            np.subtract(self.speed_box.reach, self._y_speeds, upper)
            np.minimum(self._reserved, upper, out=upper)
        else:
            np.minimum(self._reserved, self.speed_box.reach, out=upper)
        return self._tightest <= 0.0

    def _solve(self, error: Array, length: float, yields: bool) -> Array:
        """Speeds q, p (12,) for which every row holds, whatever the solver answers."""
        qp, room, upper = self.qp, self._room, self._upper
        self._right[:] = room
        if min(upper.tolist()) < CLOSED:
            upper[upper < CLOSED] = 0.0
        shut = room < CLOSED if self._tightest < CLOSED else None
        if shut is not None:
            # A closed row fixes every variable that it counts, and need not be passed.
            upper[(self._scaled[shut] > 0.0).any(axis=0)] = 0.0
            self._right[shut] = 1.0
        inverse = self._relax(qp, length)
        np.multiply(SENSES.dot(error), inverse, self._lyapunov)
        if yields:  # |y + p - q|^2 and e.(y + p - q) with y given
            np.multiply(self._y, -2.0, self._pull[:6])
            np.multiply(self._y, 2.0, self._pull[6:])
            qp.right[_LYAPUNOV] = -inverse * float(error.dot(self._y))
        else:
            self._pull.fill(0.0)
            qp.right[_LYAPUNOV] = 0.0
        speeds = qp.solve()[:12]
        if shut is not None:
            self._excess[shut] = -room[shut]
        if qp.largest_excess > 0.0:
            self._shorten(speeds)
        return speeds

    def _shorten(self, speeds: Array) -> None:
        """Shorten q, p (12,) in place until the rows hold: the feasible set is star-shaped about 0, so they all do."""
        room = self._room
        used = np.dot(self._scaled, speeds)
        over = used > room
        factor = float((room[over] / used[over]).min(initial=1.0))
        speeds *= factor
        np.subtract(factor * used, room, out=self._excess)
