"""Measurement errors within their bound, from none to one that knows the contact.

The two clever ones know the true wrench, the limits and the present stiffness matrix K of the contact (``-dw/dx``):

* ``axis`` hides as much of the worst axis as it may, and distorts every other axis so that yielding on it pushes the
  worst axis further up;
* ``potential`` picks, among many corners of the error box, the one after which moving along the yielding raises the
  true distance from the box of ``yield_start`` limits most.
"""

from __future__ import annotations

import numpy as np

from shared.spatial import Array

KINDS = ("none", "constant", "random", "corner", "axis", "potential")
CLEVER = ("axis", "potential")
YIELD_START = 0.8  # of the rounded form, which ``potential`` works against


class Adversary:
    """Chooses the error of every sample."""

    def __init__(
        self, kind: str, bound: Array, limit: Array, rng: np.random.Generator, first: Array | None = None
    ) -> None:
        """Errors of ``kind`` within ``bound`` (6,) [N, Nm]; a constant one is ``first`` (6,), or drawn."""
        self._kind = kind
        self._bound = bound
        self._limit = limit
        self._rng = rng
        self._last = bound * rng.choice((-1.0, 1.0), 6) if first is None else first

    def error(self, wrench: Array, stiffness: Array | None) -> Array:
        """Error (6,) of this sample.

        Args:
            wrench: (6,) the true one.
            stiffness: (6, 6) the present tangent; only the clever kinds need it.

        Raises:
            ValueError: if a clever kind is asked without a tangent.
        """
        if self._kind in CLEVER and stiffness is None:
            raise ValueError(f"adversary {self._kind!r} needs the contact's stiffness matrix")
        match self._kind:
            case "none":
                self._last = np.zeros(6)
            case "random":
                self._last = self._bound * self._rng.uniform(-1.0, 1.0, 6)
            case "corner":
                self._last = self._bound * self._rng.choice((-1.0, 1.0), 6)
            case "axis" if stiffness is not None:
                self._last = self._bound * self._hide_worst_axis(wrench, stiffness)
            case "potential" if stiffness is not None:
                self._last = self._bound * self._raise_potential(wrench, stiffness)
        return self._last

    def hold(self) -> Array:
        """The last error (6,) once more."""
        return self._last

    def _hide_worst_axis(self, wrench: Array, matrix: Array) -> Array:
        worst = int(np.argmax(np.abs(wrench) / self._limit))
        sign = np.where(wrench >= 0.0, 1.0, -1.0)
        # Yielding moves axis j along sign_j; that changes the worst axis by -matrix[worst, j] sign_j.
        helps = -sign[worst] * matrix[worst] * sign > 0.0
        helps[worst] = False
        return np.where(helps, sign, -sign)

    def _raise_potential(self, wrench: Array, matrix: Array) -> Array:
        usable = self._limit - self._bound
        room = (1.0 - YIELD_START) * usable
        corners = self._rng.choice((-1.0, 1.0), (24, 6))
        corners[0] = self._hide_worst_axis(wrench, matrix)
        seen = wrench + corners * self._bound
        yielding = np.sign(seen) * np.maximum(np.abs(seen) - YIELD_START * usable, 0.0) / room**2
        beyond = np.sign(wrench) * np.maximum(np.abs(wrench) - YIELD_START * usable, 0.0) / room**2
        size = np.linalg.norm(yielding * room, axis=1) + 1e-12
        growth = -(yielding @ matrix.T) @ beyond / size
        return corners[int(np.argmax(growth))]
