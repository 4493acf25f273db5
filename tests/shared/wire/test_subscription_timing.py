"""One topic's receiving end: age, silence, delay growth, loss and rate, on a clock that the test moves."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.faults import FaultKind
from shared.wire.subscription import LOSS_LIMIT
from tests.shared.rig import Feed, Publisher, ft_sample


@pytest.mark.parametrize(("period", "limit"), [(0.001, 0.03), (0.01, 0.03), (0.02, 0.06), (1 / 30, 0.1), (0.2, 0.1)])
def test_silence_is_three_measured_periods_but_no_less_than_the_maximum_age(period: float, limit: float) -> None:
    feed = Feed(period=period)
    feed.run(60)
    assert feed.subscription.period == pytest.approx(period, rel=1e-6)
    assert feed.subscription.age_limit == pytest.approx(limit, rel=1e-3)
    feed.clock.advance(limit * 0.99)
    assert feed.fault() is None
    feed.clock.advance(limit * 0.02)
    assert feed.fault() is FaultKind.SILENT


def test_a_stamp_that_lies_cannot_stretch_the_allowed_age(feed: Feed) -> None:
    feed.run(5)
    for hour in range(1, 20):
        feed.clock.advance(0.01)
        feed.subscription.offer(feed.first.payload(ft_sample(), stamp=feed.first.stamp() + hour * 3_600 * 10**9))
    assert feed.subscription.age_limit <= 0.1


@given(epoch=st.floats(-1e5, 1e5), transit=st.floats(0, 0.5))
@settings(max_examples=30, deadline=None)
def test_delay_growth_is_seen_without_synchronised_clocks(epoch: float, transit: float) -> None:
    feed = Feed()
    feed.first = Publisher(feed.clock, epoch=epoch)
    for growth, expected in ((0.0, None), (0.015, None), (0.025, FaultKind.DELAYED), (0.0, None)):
        for _ in range(20):
            feed.clock.advance(0.01)
            sent = feed.first.payload(ft_sample())
            feed.clock.advance(transit + growth)
            feed.subscription.offer(sent)
            latest = feed.subscription.latest
            assert latest is not None and latest.delay == pytest.approx(growth, abs=3e-3)
        assert feed.fault() is expected
        assert feed.subscription.age(feed.clock.now) == pytest.approx(growth, abs=3e-3)


def test_delay_is_measured_again_for_a_new_session(feed: Feed) -> None:
    feed.run(5)
    feed.clock.advance(0.2)
    feed.run(1, Publisher(feed.clock, session=2, epoch=-77.0))
    latest = feed.subscription.latest
    assert latest is not None and latest.header.session == 2 and latest.delay == 0.0


def test_a_burst_after_a_stall_is_late_until_it_is_through(feed: Feed) -> None:
    feed.run(20)
    held_back = []
    for _ in range(100):
        feed.clock.advance(0.01)
        held_back.append(feed.first.payload(ft_sample()))
    for payload in held_back[:-3]:
        feed.subscription.offer(payload)
        assert feed.fault() is FaultKind.DELAYED
    feed.subscription.offer(held_back[-1])
    assert feed.fault() is None
    assert feed.subscription.age(feed.clock.now) < 0.001


@pytest.mark.parametrize(("lost", "usable"), [(0.0, 1.0), (0.05, 1.0), (0.2, 0.99), (0.4, 0.1), (0.6, 0.0)])
def test_random_loss(feed: Feed, lost: float, usable: float) -> None:
    """A fifth lost on average passes, two fifths do not; the share over a second is what is judged."""
    draw = random.Random(7)
    judged = []
    for index in range(6000):
        feed.clock.advance(0.01)
        payload = feed.first.payload(ft_sample())
        if draw.random() >= lost:
            feed.subscription.offer(payload)
            if index > 100:
                judged.append(feed.subscription.loss() <= LOSS_LIMIT)
    assert np.mean(judged) >= usable if lost < LOSS_LIMIT else np.mean(judged) <= usable


def test_the_sequences_of_two_sessions_are_no_loss(feed: Feed) -> None:
    feed.run(50)
    feed.clock.advance(0.2)
    second = Publisher(feed.clock, session=2)
    second.seq = 10**6
    feed.run(30, second)
    assert feed.subscription.loss() == 0.0
    assert feed.fault() is None


def test_the_first_messages_do_not_count_as_loss(feed: Feed) -> None:
    for seq in (0, 2, 5):
        feed.clock.advance(0.01)
        feed.offer(seq=seq)
    assert feed.subscription.loss() == 0.0
    assert feed.fault() is None


def test_the_rate_is_that_of_the_last_second(feed: Feed) -> None:
    feed.run(300)
    assert feed.subscription.rate(feed.clock.now) == pytest.approx(100.0, rel=0.02)
    feed.clock.advance(2.0)
    assert feed.subscription.rate(feed.clock.now) == 0.0


def test_messages_that_wait_are_known_by_the_first_of_them(feed: Feed) -> None:
    feed.run(10)
    number = feed.subscription.accepted
    feed.clock.advance(0.01)
    first = feed.clock.now
    feed.offer()
    feed.run(4)
    assert feed.subscription.waiting_since(number) == first
    assert feed.subscription.waiting_since(feed.subscription.accepted - 1) == feed.clock.now
    feed.clock.advance(5.0)
    feed.run(1)
    assert feed.subscription.waiting_since(0) == feed.clock.now
