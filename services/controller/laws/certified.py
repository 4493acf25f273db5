"""The certified law: force limits that hold between samples too, for every contact within the declared bounds.

``v = y + p - q`` with ``p, q >= 0``. The yielding y retreats; p and q go where the target wants, within twelve rows
that bound what they and everything in flight can add to each ``|w_i|``. The strict form (``yield_start`` = 1) and the
rounded one (< 1) differ in where y begins and in the caps. Rules are numbered as in docs/guarantee.md, "The law".
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from services.controller.bounds.caps import AXES, UNITS, Caps
from services.controller.bounds.rows import Rows
from services.controller.bounds.stiffness_bound import StiffnessBound
from services.controller.bounds.travel_in_flight import FALL, GROW, SENSES, directed
from services.controller.bounds.yielding import RoundedYield, StrictYield, Yielding, YieldInput, scaled_into
from services.controller.laws.law import Law, LawInput, LawOutput
from services.controller.laws.qp import CLOSED, UNBOUNDED, Qp, QpFailure, Timer, no_timer
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

_SPEEDS, _GAMMA = slice(0, 12), 12
"""Variables of the quadratic program."""
_ROWS, _LYAPUNOV = slice(0, 12), 12
"""Its rows."""
_NEXT_TO_NONE = 1e-4
"""Speed [m/s, rad/s] up to which a target would hardly be seen to be followed."""
_ZERO = np.zeros(12)
_NO_YIELDING = np.zeros(6)


class CertifiedLaw(Law):
    """The certified law in its strict and its rounded form.

    Attributes:
        y: (6,) [m/s, rad/s], the yielding of the last step.
    """

    name = "certified"

    def __init__(self, parameters: ControllerParameters, timer: Timer = no_timer, previous: Law | None = None) -> None:
        super().__init__(parameters, timer, previous)
        T = parameters.period
        self.rounded = parameters.yield_start < 1.0
        # D: from a wrench to the full answer to it; the strict form counts one more period.
        self.response_time = parameters.horizon if self.rounded else parameters.horizon + T
        self.bound = StiffnessBound(parameters.contact_zones)
        self._turn_of_command = parameters.max_angular * T
        self._version = -1  # of the bound that the rows have
        self.caps = Caps(parameters.reserve, parameters.yield_start)
        self._nominal = _NO_YIELDING
        self._remarked: Array | None = None  # levels that ``remark`` is about
        self._in_force: tuple[Any, ...] = ()  # of what, and the limits in force (6,)
        if isinstance(previous, CertifiedLaw):
            self.caps.promise, self._nominal = previous.caps.promise, previous._nominal
        self.rows = Rows(T, parameters.horizon)
        self._yielding: Yielding = RoundedYield() if self.rounded else StrictYield()
        self.y, self._y_speeds = _NO_YIELDING, _ZERO
        # |p|^2 + |q|^2 in place of |p - q|^2: the same minimum without p_i and q_i opposing each other.
        qp = self.qp = Qp(np.array([1.0] * 12 + [0.0]), 13, timer, T)
        qp.upper[_GAMMA] = UNBOUNDED
        qp.rows[_LYAPUNOV, _GAMMA] = -1.0
        self._upper, self._cost = qp.upper[_SPEEDS], qp.cost[_SPEEDS]
        self._right, self._excess = qp.right[_ROWS], qp.excess[_ROWS]
        self._lyapunov = qp.rows[_LYAPUNOV, _SPEEDS]

    def brake(self, dt: float) -> None:
        super().brake(dt)
        self._yielding.brake(self.response_time, dt)

    def start(self) -> None:
        self.caps.promise = None

    def limit_in_force(self, limit: Array, nominal: Array) -> Array:
        promise, known = self.caps.promise, self._in_force
        if promise is None:
            return limit
        if not (known and known[0] is limit and known[1] is nominal and known[2] is promise):
            promised = np.array(promise) + np.abs(nominal - self._nominal)
            found = np.maximum(limit, promised) if np.any(promised > limit) else limit
            known = self._in_force = limit, nominal, promise, found
        return known[3]

    def _move(self, state: LawInput, error: Array, length: float, dt: float) -> LawOutput:
        error_bound = state.error_bound
        if self.speed_box.payload:
            error_bound = error_bound + self.speed_box.inertial_force
        self._keep_limits(state, error_bound)
        if self.caps.refusal is not None:
            inertia = self.speed_box.inertial_force.max()
            of = f"; of that payload_mass x max_acceleration is {inertia:.3g} N, which no tare lowers"
            return LawOutput(self._rest, failure=self.caps.refusal + (of if inertia > 0.5 * error_bound.max() else ""))
        yields = self._yield(state, dt)
        self._find_room(state, yields, dt)
        if yields and self.rounded and self.rows.tightest <= 0.0:
            # Nothing but the retreat may move while a row has no room.
            retreats = SENSES.dot(self.y) < 0.0
            return LawOutput(self.y, np.where(retreats, 0.0, -np.inf), retreats=True)
        try:
            speeds, failure = self._solve(error, length, yields), None
        except QpFailure as problem:
            speeds, failure = _ZERO, self._recorded(problem)  # y alone needs no solver
            self._excess.fill(0.0)
        v = speeds[FALL] - speeds[GROW]
        if yields:
            v += self.y
        return LawOutput(v, np.maximum(self._excess, speeds - self.rows.reserved), yields, failure, state)

    def _keep_limits(self, state: LawInput, error_bound: Array) -> None:
        """The caps, the stiffness bound, and the limits in force: no wrench that is there or on its way passes them."""
        caps = self.caps
        if state.nominal is not self._nominal:
            caps.shift(state.nominal - self._nominal)
            self._nominal, self._in_force = state.nominal, ()
        caps.update(state.limit, error_bound)
        if caps.refusal is not None:
            return
        if caps.promise is None:  # nothing is in flight at the start
            caps.lower(-SENSES.dot(state.wrench))
        self._bound_stiffness(state)
        if caps.lowering:
            caps.lower(self.rows.M.dot(self.travel.in_flight) - SENSES.dot(state.wrench))
            self._bound_stiffness(state)  # with what F is now
        if caps.levels is not self._remarked:
            self._remarked, self.remark = caps.levels, self._forbidden()

    def _forbidden(self) -> str:
        """The slowest axis, if limits, errors and contacts leave the target next to no motion along it."""
        _, lasting, reserved = self.caps.levels[:, :6].tolist()
        K, horizon = self.bound.rows, self.parameters.horizon
        axes = range(6)
        speeds = [min(reserved[i] / K[i][i], *(lasting[j] / K[j][i] for j in axes)) / horizon for i in axes]
        i = min(axes, key=speeds.__getitem__)
        if speeds[i] > _NEXT_TO_NONE:
            return ""
        if reserved[i] <= 0.0:
            remedy = "Raise the limit, or let go of the tool and `tandem tare`"
            cause = f"its error bound is {self.caps.errors[i]:.3g} {UNITS[i]}. {remedy}"
        else:
            cause = "the contacts are declared too stiff for them. See `tandem certify`"
        return f"the limits leave the target no motion {AXES[i]}: {cause}"

    def _bound_stiffness(self, state: LawInput) -> None:
        """Rules 1 and 2: Kbar and M for this attitude, and for all that s and the next command can turn it by."""
        # F, the limit in force + |nominal force|, bounds the sum of the contacts' forces where they do not squeeze.
        x, y, z = self.caps.force
        nx, ny, nz, *_ = state.nominal.tolist()
        force = [x + abs(nx), y + abs(ny), z + abs(nz)]
        s = self.travel.in_flight.tolist()
        back, ahead = s[3:6], s[9:12]  # about x, y and z
        turn = max(back[0] + ahead[0], back[1] + ahead[1], back[2] + ahead[2])
        self.bound.update(state.rotation, turn + self._turn_of_command, force)
        if self.bound.version != self._version:
            self._version = self.bound.version
            self.rows.update(self.bound)
            self.qp.rows[_ROWS, _SPEEDS] = self.rows.scaled

    def _yield(self, state: LawInput, dt: float) -> bool:
        """Rule 3: set y, within the speed box; returns whether there is any.

        Unless the environment has moved, ``T M y <= max(0, C -+ w - M s)``, C of the limits in force.
        """
        w, caps, yielding = state.wrench.tolist(), self.caps, self._yielding
        y = None
        if not yielding.at_rest or any(map(operator.gt, map(abs, w), caps.threshold)):
            displacement = min(dt, self.parameters.period) * self.twist
            y = yielding.step(
                YieldInput(w, caps, self.bound, self.speed_box.speed, displacement, self.response_time, dt)
            )
        if y is None:
            self.y, self._y_speeds = _NO_YIELDING, _ZERO
            return False
        reach = self.speed_box.retreat_reach(self.travel.speeds, dt)
        if yielding.moved:
            self.y = np.clip(y, -reach[GROW], reach[FALL])
            self._y_speeds = directed(self.y)
        else:  # shortened as a whole, it still goes down the gradient
            back, ahead = reach[GROW].tolist(), reach[FALL].tolist()
            y = scaled_into(y, [ahead[i] if y[i] > 0.0 else back[i] for i in range(6)])
            wanted = directed(np.array(y))
            asked = float(wanted.sum())
            speeds = self._y_speeds = self._keep_rows(wanted, state.wrench)
            self.y = speeds[FALL] - speeds[GROW]
            yielding.left(float(speeds.sum()) / asked if asked > 0.0 else 1.0, caps.shifted, dt)
        return bool(self._y_speeds.any())

    def _keep_rows(self, y: Array, wrench: Array) -> Array:
        """Rule 3: the speeds y (12,), shortened to ``T M y <= max(0, C -+ w - M s)``: at rest that breaks no limit."""
        M = self.rows.M
        room = np.tile(self.caps.most, 2) + SENSES.dot(wrench) - M.dot(self.travel.in_flight)
        shut = room <= 0.0
        if shut.any():
            y[(M[shut] > 0.0).any(axis=0)] = 0.0
        return y * _fit(self.parameters.period * M.dot(y), np.maximum(room, 0.0))

    def _find_room(self, state: LawInput, yields: bool, dt: float) -> None:
        """Rules 4 to 6, for the caps A and the path ``s + T y``: see ``Rows.find``."""
        path, levels = self.travel.in_flight, self.caps.levels
        if yields:
            path = path + self.parameters.period * self._y_speeds
            if isinstance(self._yielding, RoundedYield):
                levels = self.caps.levels_at(self._yielding.distance)
        self.rows.find(state.wrench, path, levels, dt)

    def _solve(self, error: Array, length: float, yields: bool) -> Array:
        """Rule 7: of the speeds [q; p] (12,) for which every row holds, those that the target wants most.

        The program, with ``v = y + p - q``, e the error of the pose, and rules 4 to 6 as ``room`` and ``reserved``::

            minimise  |p|^2 + |q|^2 + 2 y.(p - q) + k gamma
            with      scaled [q; p] <= room,  0 <= [q; p] <= reserved,  v within the speed box,
                      e.v <= -(lambda/2)|e|^2 + gamma,  gamma >= 0
        """
        qp, rows, upper = self.qp, self.rows, self._upper
        free = self.speed_box.reach
        if yields:  # what y does not use; y against a direction frees none of it, and y alone may be beyond it
            free = np.maximum(free - self._y_speeds, 0.0)
        np.minimum(rows.reserved, free, out=upper)
        self._right[:] = rows.room
        if min(upper.tolist()) < CLOSED:
            upper[upper < CLOSED] = 0.0
        shut = rows.room < CLOSED if rows.tightest < CLOSED else None
        if shut is not None:
            # A closed row fixes every variable that it counts, and need not be passed.
            upper[(rows.scaled[shut] > 0.0).any(axis=0)] = 0.0
            self._right[shut] = 1.0
        inverse = self._relax(length)
        np.multiply(SENSES.dot(error), inverse, self._lyapunov)
        if yields:
            np.multiply(SENSES.dot(self.y), 2.0, out=self._cost)
            qp.right[_LYAPUNOV] = -inverse * float(error.dot(self.y))
        else:
            self._cost.fill(0.0)
            qp.right[_LYAPUNOV] = 0.0
        speeds = qp.solve()[_SPEEDS]
        if shut is not None:
            self._excess[shut] = -rows.room[shut]
        if qp.largest_excess > 0.0:
            self._shorten(speeds)
        return speeds

    def _shorten(self, speeds: Array) -> None:
        """Rule 7: shorten q, p (12,) in place until every row holds: the feasible set is star-shaped about 0."""
        room = self.rows.room
        used = self.rows.scaled.dot(speeds)
        factor = _fit(used, room)
        speeds *= factor
        np.subtract(factor * used, room, out=self._excess)


def _fit(used: Array, room: Array) -> float:
    """The largest factor <= 1 with ``factor * used <= room``, row by row."""
    over = used > room
    return float((room[over] / used[over]).min(initial=1.0))
