"""Steady clocks. Nothing that controls ever asks what time of day it is."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """A clock that never goes backwards."""

    def now_ns(self) -> int:
        """Time [ns] since an arbitrary instant."""
        ...


class SteadyClock:
    """The machine's monotonic clock."""

    def now_ns(self) -> int:
        """Time [ns] since an arbitrary instant."""
        return time.monotonic_ns()


def seconds(nanoseconds: int) -> float:
    """A duration [ns] in seconds."""
    return nanoseconds * 1e-9


def in_words(duration: float) -> str:
    """A duration [s] as a person says it: seconds below two minutes, else minutes."""
    return f"{duration:.0f} s" if duration < 120.0 else f"{duration / 60.0:.0f} min"


def nanoseconds(duration: float) -> int:
    """A duration [s] in whole nanoseconds."""
    return round(duration * 1e9)
