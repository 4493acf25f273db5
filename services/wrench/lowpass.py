"""Low pass of the external wrench."""

from __future__ import annotations

import math

from shared.spatial import Array


class LowPass:
    """First-order low pass of the external wrench, exact for an input held over each step.

    It delays what the controller sees: a ramp comes out 1 / (2 pi f) [s] late, which has to be counted in the
    controller's `delay`. It is not credited in the error bound.
    """

    def __init__(self) -> None:
        self._state: Array | None = None

    def filter(self, value: Array, cutoff: float, dt: float) -> Array:
        """The filtered value (6,); the first one after a start or a reset passes unchanged.

        Args:
            value: newest input (6,).
            cutoff: corner frequency [Hz], 0 = off.
            dt: time [s] since the last call.
        """
        if self._state is None or cutoff <= 0.0:
            self._state = value
        else:
            self._state = self._state + (1.0 - math.exp(-2.0 * math.pi * cutoff * dt)) * (value - self._state)
        return self._state

    def reset(self) -> None:
        """Forget the past, after a gap or a change of the compensation."""
        self._state = None
