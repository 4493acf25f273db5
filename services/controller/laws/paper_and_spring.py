"""The laws that bound every axis of the twist by itself: the paper's and the spring that it is compared with."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from services.controller.laws.law import Law, LawInput, LawOutput
from services.controller.laws.qp import CLOSED, UNBOUNDED, Qp, QpFailure, Timer, no_timer
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

_GAMMA = 6


class BoxLaw(Law):
    """``minimise |v|^2 + k gamma`` in the 7 variables v, gamma, with ``l <= v <= u``."""

    def __init__(self, parameters: ControllerParameters, timer: Timer = no_timer, previous: Law | None = None) -> None:
        super().__init__(parameters, timer, previous)
        self.qp = Qp(np.array([1.0] * 6 + [0.0]), 1, timer, parameters.period)
        self.qp.upper[_GAMMA] = UNBOUNDED
        self.qp.rows[0, _GAMMA] = -1.0

    @abstractmethod
    def _bounds(self, state: LawInput, error: Array) -> tuple[Array, Array]:
        """The law's own bounds l, u (6,) [m/s, rad/s], before the speed limits."""

    def _move(self, state: LawInput, error: Array, length: float, dt: float) -> LawOutput:
        qp, reach = self.qp, self.speed_box.reach
        own_lower, own_upper = self._bounds(state, error)
        # A bound beyond the speed limits closes on them: the box is never empty.
        lower = np.minimum(np.maximum(own_lower, -reach[:6]), reach[6:])
        upper = np.minimum(np.maximum(own_upper, -reach[:6]), reach[6:])
        qp.lower[:_GAMMA] = lower
        qp.upper[:_GAMMA] = np.where(upper - lower > CLOSED, upper, lower)
        qp.rows[0, :_GAMMA] = self._relax(length) * error
        try:
            v, failure = np.minimum(np.maximum(qp.solve()[:_GAMMA], lower), upper), None
        except QpFailure as problem:
            # The point of the box next to standing still needs no solver; it retreats where the box demands it.
            v = np.minimum(np.maximum(0.0, lower), upper)
            failure = self._recorded(problem)
        # The lower bound of v_i keeps w_i below its upper limit.
        excess = np.concatenate((own_lower - v, v - own_upper))
        output = LawOutput(v, excess, failure=failure)
        output.retreats = bool(output.active.any())
        return output


class PaperLaw(BoxLaw):
    """The paper's barriers, one per axis: ``-w_i v_i <= -(alpha_i/2)(w_i^2 - wbar_i^2)`` (Theorem 1, Eq. (9b))."""

    name = "paper"

    def _bounds(self, state: LawInput, error: Array) -> tuple[Array, Array]:
        alpha = self.parameters.barrier_rate
        lower, upper = [-UNBOUNDED] * 6, [UNBOUNDED] * 6
        for i, (w, limit) in enumerate(zip(state.wrench.tolist(), state.limit.tolist(), strict=True)):
            # v_i >= (alpha_i/2)(w_i^2 - wbar_i^2)/w_i for w_i > 0, <= for w_i < 0, none for w_i = 0.
            if w > 0.0:
                lower[i] = max(-UNBOUNDED, 0.5 * alpha[i] * (w - limit * limit / w))
            elif w < 0.0:
                upper[i] = min(UNBOUNDED, 0.5 * alpha[i] * (w - limit * limit / w))
        return np.array(lower), np.array(upper)


class StiffnessLaw(BoxLaw):
    """A damped spring to the target: ``v_i = (w_i - K_i e_i)/D_i``, the baseline without force limits.

    The damping is not a parameter of its own: ``D_i = 2 K_i / min(k, lambda)`` lets the free tool converge exactly as
    fast as it does under the other laws.
    """

    name = "stiffness"

    def _bounds(self, state: LawInput, error: Array) -> tuple[Array, Array]:
        rate = 0.5 * min(self.parameters.relaxation_weight, self.parameters.lyapunov_rate)
        v = rate * (state.wrench / np.array(self.parameters.spring_stiffness) - error)
        return v, v
