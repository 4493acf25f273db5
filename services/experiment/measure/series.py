"""Series over time: values at other times, and how fast they change."""

from __future__ import annotations

import numpy as np

SMOOTHING = 0.2  # [s] over which a speed is taken


def at(time: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A series (m, k) at other times (n,), linearly in between: (n, k)."""
    return np.column_stack([np.interp(time, times, column) for column in values.T])


def rate(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Rates of change (n, k) per second of a series (n, k), over SMOOTHING."""
    ahead = np.minimum(time + SMOOTHING / 2, time[-1])
    behind = np.maximum(time - SMOOTHING / 2, time[0])
    return (at(ahead, time, values) - at(behind, time, values)) / np.maximum(ahead - behind, 1e-9)[:, None]
