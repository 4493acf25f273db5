"""Travel in flight against a brute-force integration of what the robot still does."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.controller.bounds.travel_in_flight import TravelInFlight

STEP = 2e-4


def still_to_come(
    sent: list[tuple[float, np.ndarray]], arrivals: list[float], now: float, period: float, sample: float, lag: float
) -> np.ndarray:
    """Travel (12,) that the robot makes after the instant ``sample`` from what was sent before ``now``.

    A command acts from its arrival to the next one's, at most for ``period``; the robot follows with ``lag``.
    """
    events = sorted((arrival, index) for index, arrival in enumerate(arrivals) if math.isfinite(arrival))
    start = sent[0][0]
    end = now + 10 * lag + 3 * period + 0.1
    velocity = np.zeros(6)
    total = np.zeros(12)
    decay = math.exp(-STEP / lag) if lag > 0 else 0.0
    position = 0
    for step in range(int((end - start) / STEP)):
        time = start + step * STEP
        while position + 1 < len(events) and events[position + 1][0] <= time:
            position += 1
        arrival, index = events[position]
        acting = arrival <= time < arrival + period
        wanted = sent[index][1] if acting else np.zeros(6)
        velocity = wanted + decay * (velocity - wanted)
        if time >= sample:
            total[:6] += STEP * np.maximum(-velocity, 0.0)
            total[6:] += STEP * np.maximum(velocity, 0.0)
    return total


@pytest.mark.parametrize("seed", range(6))
def test_nothing_that_is_still_to_come_is_forgotten(seed: int) -> None:
    """Jittering intervals, varying transport, lost commands, a lag: what is counted is never less than what comes."""
    rng = np.random.default_rng(seed)
    nominal = float(rng.choice((0.004, 0.01, 0.033)))
    jitter = rng.uniform(0.0, 0.4) * nominal
    latency, fastest = rng.uniform(0.0, 0.01), rng.uniform(0.0, 0.02)
    lag = float(rng.choice((0.0, 0.01, 0.03)))
    period = 1.2 * nominal + jitter
    travel = TravelInFlight(period, latency + fastest + jitter, lag)
    time, sent, arrivals = 0.0, [], []
    for count in range(30):
        dt = nominal * rng.uniform(0.8, 1.2) * (1 if rng.random() < 0.9 else 3)
        in_flight = travel.advance(dt if count else 0.0).copy()
        time += dt if count else 0.0
        if count % 5 == 4:
            expected = still_to_come(
                [*sent, (time, np.zeros(6))], [*arrivals, time + fastest + jitter], time, period, time - latency, lag
            )
            slack = 6 * STEP * np.max(np.abs([v for _, v in sent]))  # of the integration, a step per switch
            assert np.all(in_flight >= expected - slack), (seed, count, in_flight - expected)
        twist = rng.normal(size=6) * (rng.random() < 0.8)
        travel.command(twist)
        sent.append((time, twist))
        lost = count > 0 and rng.random() < 0.1
        arrivals.append(math.inf if lost else time + fastest + jitter * rng.random())


def after(travel: TravelInFlight, dt: float, *twists: np.ndarray) -> np.ndarray:
    """What is in flight (12,) ``dt`` [s] after the last of several commands, given at intervals of ``dt``."""
    for twist in twists:
        travel.advance(dt)
        travel.command(twist)
    return travel.advance(dt)


ALL, NONE = np.ones(6), np.zeros(6)
ALONG_X = np.array((1.0, 0.0, 0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(("dt", "period", "delay", "lag"), [(0.01, 0.02, 0.02, 0.02), (0.001, 0.0012, 0.03, 0.0)])
def test_a_steady_command_is_counted_exactly(dt: float, period: float, delay: float, lag: float) -> None:
    twist = np.array((0.1, -0.2, 0.0, 0.3, 0.0, -0.4))
    expected = np.concatenate((np.maximum(-twist, 0), np.maximum(twist, 0))) * (delay + lag)
    found = after(TravelInFlight(period, delay, lag), dt, *[twist] * 2000)
    assert found == pytest.approx(expected, rel=1e-6)


def test_senses_are_never_netted() -> None:
    in_flight = after(TravelInFlight(0.01, 0.05, 0.0), 0.01, *(0.1 * sign * ALL for sign in (1, -1, 1, -1)))
    assert np.all(in_flight >= 0.1 * 0.02 - 1e-12)


def test_it_ends_after_delay_and_lag() -> None:
    travel = TravelInFlight(0.01, 0.02, 0.005)
    assert np.all(after(travel, 0.01, ALL)[6:] >= 0.01 - 1e-12)
    assert np.all(after(travel, 0.01, *[NONE] * 21) < 1e-12)


def test_a_command_acts_no_longer_than_the_period_however_long_the_pause() -> None:
    travel = TravelInFlight(0.01, 0.5, 0.0)
    travel.command(ALL)
    assert travel.advance(0.4)[6:] == pytest.approx(np.full(6, 0.01))


def test_many_commands_in_a_short_time_are_bounded_and_not_forgotten() -> None:
    travel = TravelInFlight(0.2, 0.1, 0.0)
    assert np.all(after(travel, 1e-5, *[0.5 * ALL] * 5000)[6:] >= 0.5 * 0.05 - 1e-9)


def test_no_time_no_change() -> None:
    travel = TravelInFlight(0.01, 0.02, 0.01)
    before = after(travel, 0.005, ALL).copy()
    assert travel.advance(0.0) == pytest.approx(before)


def test_of_two_commands_at_one_instant_the_larger_counts() -> None:
    """A step that fails after its command is followed by a brake at once: whichever is lost, the other one acts."""
    travel = TravelInFlight(0.02, 0.05, 0.0)
    travel.advance(0.01)
    travel.command(0.2 * ALONG_X)
    travel.command(NONE)
    assert travel.advance(0.01)[6] >= 0.2 * 0.01 * (1.0 - 1e-9)


def test_more_segments_than_are_kept_are_merged_without_losing_any_time() -> None:
    """A loop far quicker than the delay: everything of the last d is still counted, never less."""
    delay, dt = 0.1, 1.0 / 4000.0
    in_flight = after(TravelInFlight(0.001, delay, 0.0), dt, *[0.1 * ALONG_X] * 2000)[6]
    assert 0.1 * delay * (1.0 - 1e-9) <= in_flight <= 0.1 * (delay + 2.0 * dt)
