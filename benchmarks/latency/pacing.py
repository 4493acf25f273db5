"""Pacing and matching, alike for every transport; the standard library only, since ROS brings its own interpreter."""

from __future__ import annotations

import bisect
import json
import time
from collections.abc import Iterator, Sequence


def paced(rate: float, seconds: float) -> Iterator[None]:
    """Yields at ``rate`` [Hz] for ``seconds`` [s]; after a stall it goes on from there instead of catching up."""
    period = round(1e9 / rate)
    due = time.monotonic_ns()
    end = due + round(seconds * 1e9)
    while due < end:
        left = due - time.monotonic_ns()
        if left > 0:
            time.sleep(left * 1e-9)
        elif left < -period:
            due = time.monotonic_ns()
        due += period
        yield


def answers(puts: Sequence[int], arrivals: Sequence[int]) -> list[float | None]:
    """Latency [us] of each put's answer, None for a put that was never answered.

    Answers come in order and at most one per put, but do not say which put caused them: a service that was late
    answers the newest sample and passes over the older. From the last answer backwards each is matched with the newest
    put that it can belong to: one before which no answer was due yet, and not impossibly fast (half the median).

    Args:
        puts: steady clock [ns] just before each put, ascending; mostly answered before the next one.
        arrivals: steady clock [ns] of each answer, ascending.
    """
    since_put = sorted(
        arrival - puts[after - 1] for arrival in arrivals if (after := bisect.bisect_left(puts, arrival))
    )
    least = since_put[len(since_put) // 2] // 2 if since_put else 0
    matched: list[float | None] = [None] * len(puts)
    free = len(puts)
    for arrival in reversed(arrivals):
        free = bisect.bisect_right(puts, arrival - least, 0, free) - 1
        if free < 0:
            break
        matched[free] = (arrival - puts[free]) * 1e-3
    return matched


def printed(puts: Sequence[int], arrivals: Sequence[int], begin: int, end: int, **more: object) -> None:
    """Print as JSON the latencies of the puts between two instants [ns], and whatever else was measured."""
    matched = answers(puts, arrivals)
    inside = [latency for put, latency in zip(puts, matched, strict=True) if begin <= put < end]
    print(json.dumps({"latencies": inside, **more}))
