"""The twelve rows that keep every axis of the wrench below its cap, and the room that each of them leaves now.

Row i keeps w_i below its cap, row 6 + i keeps -w_i below it. Motion along -i (q_i) makes w_i grow, motion along +i
(p_i) makes it fall. With the caps A, the travel in flight s and the yielding y, the rules of docs/guarantee.md,
"The law", are::

    rule 1   M = [Kbar, L; L, Kbar],  L = Kbar with low_i in place of Kbar_ii
    rule 4   T M [q; p] <= max(0, A -+ w - M (s + T y))
    rule 5   (T + d + tau) M [q; p] <= max(0, A -+ w)
    rule 6   (T + d + tau) Kbar_ii q_i <= max(0, A_i - w_i - rho_i), and the same for p_i and -w_i
"""

from __future__ import annotations

import numpy as np

from services.controller.bounds.stiffness_bound import StiffnessBound
from shared.spatial import Array

_NEXT, _LASTING, _RESERVE = 0, 1, 2
"""The rooms of rules 4, 5 and 6."""
_WRENCH, _PATH, _ONE = slice(0, 6), slice(6, 18), 18
"""The parts of the load ``[w; s + T y; 1]`` that the rooms depend on."""
_NONE = np.zeros(36)
_SIGN = np.array(((-1.0,), (1.0,)))
"""Of w_i in the room of row i, and of row 6 + i."""


class Rows:
    """The rows as speeds: each divided by its largest element, and by the time that its rule counts with.

    Args:
        period: T [s].
        horizon: T + d + tau [s].

    Attributes:
        M: (12, 12) [N/m, N/rad, Nm/m, Nm/rad] of rule 1.
        scaled: (12, 12), M with each row divided by its largest element.
        room: (12,) [m/s, rad/s] with ``scaled [q; p] <= room``, rules 4 and 5.
        tightest: [m/s, rad/s], least element of ``room``.
        reserved: (12,) [m/s, rad/s] with ``[q; p] <= reserved``, rule 6.
    """

    def __init__(self, period: float, horizon: float) -> None:
        self._horizon = horizon
        self._per_time = 1.0 / np.array((period, horizon, horizon)).reshape((3, 1, 1))
        self.M = np.zeros((12, 12))
        # The blocks (6, 6) of M by the sense of row and motion, and of these what each axis does to itself.
        self._blocks = self.M.reshape((2, 6, 2, 6)).swapaxes(1, 2)
        self._own = np.einsum("rmii->rmi", self._blocks)
        self.scaled = np.zeros((12, 12))
        self._largest = np.zeros((3, 1, 6))
        self._per_force = np.zeros((3, 12))  # speed for a newton of room
        # The rooms of all rules are one product with the load.
        matrix = np.zeros((3, 12, 19))
        self._matrix = matrix.reshape((36, 19))
        self._of_wrench = np.einsum("rsii->rsi", matrix[..., _WRENCH].reshape((3, 2, 6, 6)))
        self._of_path, self._of_one = matrix[_NEXT, :, _PATH], matrix[..., _ONE]
        self._load = np.ones(19)
        rooms = np.zeros((3, 12))
        self._rooms, self._next, self._lasting = rooms.ravel(), rooms[_NEXT], rooms[_LASTING:]
        self._levels: Array | None = None  # that the matrix has
        self._opened = np.zeros((2, 12))  # room of rules 5 and 6 that is in use
        self._usable, self.reserved = self._opened
        self._begun = False
        self.room = np.zeros(12)
        self.tightest = 0.0

    def update(self, bound: StiffnessBound) -> None:
        """Take over Kbar and low: rule 1, and how fast every newton of room lets the tool be."""
        self._blocks[:] = bound.matrix
        self._own[0, 1] = self._own[1, 0] = bound.low  # motion that makes the row's side of w_i fall
        # low_i <= Kbar_ii, so the largest element of a row of M is that of Kbar; rule 6 has no other than Kbar_ii.
        largest, per_force = self._largest, self._per_force
        largest[:_RESERVE], largest[_RESERVE] = [max(row) for row in bound.rows], bound.matrix.diagonal()
        np.divide(self.M.reshape((2, 6, 12)), largest[_NEXT].T, out=self.scaled.reshape((2, 6, 12)))
        each_sense = np.divide(self._per_time, largest, out=per_force.reshape((3, 2, 6)))
        np.multiply(_SIGN, each_sense, out=self._of_wrench)
        np.multiply(-per_force[_NEXT, :, None], self.M, out=self._of_path)
        self._levels = None

    def find(self, wrench: Array, path: Array, levels: Array, dt: float) -> None:
        """Set ``room``, ``tightest`` and ``reserved``.

        Rule 4, for the next command::

            T M [q; p] <= max(0, A -+ w - M (s + T y))

        Rule 5, for a speed that can be kept up without being stopped by its own s a moment later::

            (T + d + tau) M [q; p] <= max(0, A -+ w)

        Rule 6, the reserve that pressing inward leaves for sliding, turning and retreating::

            (T + d + tau) Kbar_ii q_i <= max(0, A_i - w_i - rho_i)
            (T + d + tau) Kbar_ii p_i <= max(0, A_i + w_i - rho_i)

        Args:
            wrench: w (6,) [N, Nm].
            path: s + T y (12,) [m, rad].
            levels: (3, 12) [N, Nm]: A for rules 4 and 5, A - rho for rule 6; another array whenever they change.
            dt: [s] since the last call.
        """
        load = self._load
        load[_WRENCH], load[_PATH] = wrench, path
        if levels is not self._levels:
            np.multiply(self._per_force, levels, out=self._of_one)
            self._levels = levels
        self._matrix.dot(load, self._rooms)
        np.maximum(self._rooms, _NONE, out=self._rooms)
        # Rules 5 and 6 shut at once and open by a share of the room that has come back: taken at once, it would be gone
        # again before the wrench shows it, and the tool would hunt.
        share = min(1.0, dt / self._horizon) if self._begun else 1.0
        self._begun = True
        change = self._lasting - self._opened
        self._opened += np.minimum(change, share * change)
        np.minimum(self._next, self._usable, out=self.room)
        self.tightest = min(self.room.tolist())
