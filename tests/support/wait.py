"""Waiting for a condition with a deadline, so that no test depends on the machine's speed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

_POLL_INTERVAL = 0.005


def eventually(
    condition: Callable[[], T],
    timeout: float = 10.0,
    message: str | Callable[[], str] = "",
    every: float = _POLL_INTERVAL,
) -> T:
    """The first truthy value of ``condition``.

    Args:
        condition: called again and again from this thread; cheap and without effect.
        timeout: [s] on the steady clock; generous, since it is spent only by a test that fails.
        message: what was awaited, for the failure; a function says it as of then.
        every: [s] between two calls; more for a condition that takes the cores from what it waits for.

    Raises:
        AssertionError: if the condition is still false at the deadline.
    """
    deadline = time.monotonic() + timeout
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            what = message() if callable(message) else message or getattr(condition, "__name__", "the condition")
            raise AssertionError(f"not within {timeout} s: {what} (last value: {value!r})")
        time.sleep(every)


def throughout(condition: Callable[[], object], duration: float, message: str = "") -> None:
    """Holds a condition against every instant of a while.

    Args:
        condition: called again and again from this thread.
        duration: [s] on the steady clock.
        message: what should have held, for the failure.

    Raises:
        AssertionError: as soon as the condition is false.
    """
    deadline = time.monotonic() + duration
    while time.monotonic() < deadline:
        assert condition(), f"held not throughout {duration} s: {message}"
        time.sleep(_POLL_INTERVAL)
