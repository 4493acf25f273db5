"""Pacing and matching, alike for every transport; the standard library only, since ROS brings its own interpreter."""

from __future__ import annotations

import bisect
import json
import time
from collections.abc import Callable, Iterator, Sequence

WARM_UP = 1.0
"""Time [s] at the beginning of a measurement that does not count."""


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

    An answer does not say which put caused it: a service that was late answers the newest sample and passes over the
    older, and one that brakes speaks without having been asked. Each answer belongs to the newest put that it can
    belong to, one that it does not follow impossibly fast (half the median); of several, the earlier ones belong to the
    puts before as long as those have no answer of their own, and the rest to none.

    Args:
        puts: steady clock [ns] just before each put, ascending; mostly answered before the next one.
        arrivals: steady clock [ns] of each answer, ascending.
    """
    since_put = sorted(
        arrival - puts[after - 1] for arrival in arrivals if (after := bisect.bisect_left(puts, arrival))
    )
    least = since_put[len(since_put) // 2] // 2 if since_put else 0
    newest = [bisect.bisect_right(puts, arrival - least) - 1 for arrival in arrivals]
    taken = set(newest)
    matched: list[float | None] = [None] * len(puts)
    for arrival, put in zip(reversed(arrivals), reversed(newest), strict=True):
        while put >= 0 and matched[put] is not None:
            put = put - 1 if put - 1 not in taken else -1
        if put >= 0:
            matched[put] = (arrival - puts[put]) * 1e-3
    return matched


def printed(puts: Sequence[int], arrivals: Sequence[int], begin: int, end: int, **more: object) -> None:
    """Print as JSON the latencies of the puts between two instants [ns], and whatever else was measured."""
    matched = answers(puts, arrivals)
    inside = [latency for put, latency in zip(puts, matched, strict=True) if begin <= put < end]
    print(json.dumps({"latencies": inside, **more}))


def probed(rate: float, seconds: float, put: Callable[[], None], arrivals: Sequence[int]) -> None:
    """Put at a rate [Hz], first to warm up and then for a time [s], and print the latencies.

    Args:
        rate: of the puts.
        seconds: of which the latencies count.
        put: what has to be answered.
        arrivals: steady clock [ns] of each answer, kept up.
    """
    puts: list[int] = []
    for _ in paced(rate, WARM_UP + seconds):
        puts.append(time.monotonic_ns())
        put()
    time.sleep(0.2)
    printed(puts, arrivals, puts[0] + round(WARM_UP * 1e9), puts[-1] + 1)
