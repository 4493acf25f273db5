"""The watch over one topic: rates, stamps, clocks and publishers, each told in one line while it is so."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from shared.robot.bridge.stream import MISSING_AFTER, REMEMBERED, StreamWatch
from shared.robot.far_side import Heard

SECOND = 10**9
WALL = 1_700_000_000 * SECOND
Stamps = Callable[[int, int], int | None]
"""Stamp [ns] of a message, by its number and arrival."""


class Topic:
    def __init__(self) -> None:
        self.watch = StreamWatch("/topic", 50.0)
        self.now = 5 * SECOND
        self.number = 0

    def go_on(
        self,
        duration: float,
        rate: float = 50.0,
        stamp: Stamps = lambda _, now: WALL + now,
        sender: Callable[[int], str] = lambda _: "/robot",
    ) -> int:
        """Let messages arrive; how many of them count."""
        counted = 0
        for _ in range(round(duration * rate)):
            self.now += round(SECOND / rate)
            self.number += 1
            message = Heard(None, self.number, self.now, stamp(self.number, self.now), sender(self.number))
            counted += self.watch.hear(message, self.now, WALL + self.now)
        return counted

    def lines(self) -> str:
        return "; ".join(self.watch.lines())


@pytest.fixture
def topic() -> Topic:
    return Topic()


def test_a_healthy_topic_has_nothing_to_tell_and_each_message_counts_once(topic: Topic) -> None:
    assert topic.go_on(5.0) == 250
    assert topic.lines() == ""


def test_a_sampled_topic_keeps_its_rate(topic: Topic) -> None:
    for _ in range(100):
        topic.number += 4
        topic.go_on(0.1, rate=10.0)
    assert topic.lines() == ""


def test_a_slow_topic_is_told_with_both_rates(topic: Topic) -> None:
    topic.go_on(5.0, rate=30.0)
    assert topic.lines() == "/topic comes at 30 Hz, the profile says 50 Hz"
    topic.go_on(5.0)
    assert topic.lines() == ""


def test_a_topic_that_never_comes_is_told_and_so_is_one_that_ends(topic: Topic) -> None:
    topic.watch.hear(None, topic.now, WALL)
    assert topic.lines() == ""
    topic.watch.hear(None, topic.now + 4 * SECOND, WALL)
    assert "/topic: nothing has arrived. Is that its name" in topic.lines()
    topic.go_on(1.0)
    topic.watch.hear(None, topic.now + round((MISSING_AFTER + 2) * SECOND), WALL)
    assert "/topic: silent for 5 s" in topic.lines()


def test_a_stamp_that_stands_is_told(topic: Topic) -> None:
    topic.go_on(1.0, stamp=lambda number, now: WALL)
    assert "its stamp stands still" in topic.lines()


def test_a_stamp_that_jumps_is_told_for_a_while(topic: Topic) -> None:
    topic.go_on(1.0)
    topic.go_on(1.0, stamp=lambda number, now: WALL + now + SECOND)
    assert "/topic: its stamp has jumped by +1.0 s" in topic.lines()
    topic.go_on(REMEMBERED + 1.0, stamp=lambda number, now: WALL + now + SECOND)
    assert topic.lines() == ""


def test_a_clock_that_is_off_is_told_whichever_way(topic: Topic) -> None:
    topic.go_on(1.0, stamp=lambda number, now: WALL + now + 3600 * SECOND)
    assert "the robot's clock is 60 min ahead of this machine's" in topic.lines()
    topic.go_on(1.0, stamp=lambda number, now: WALL + now - 60 * SECOND)
    assert "the robot's clock is 60 s behind this machine's" in topic.lines()


def test_a_topic_without_stamps_is_fine(topic: Topic) -> None:
    topic.go_on(3.0, stamp=lambda number, now: None)
    assert topic.lines() == ""


def test_of_two_publishers_the_first_is_heard_until_it_is_silent(topic: Topic) -> None:
    topic.go_on(1.0)
    assert topic.go_on(2.0, sender=lambda number: "/other" if number % 2 else "/robot") == 50
    assert "/topic has two publishers, /robot and /other: only the first is heard" in topic.lines()
    assert topic.go_on(MISSING_AFTER + 1.0, sender=lambda number: "/other") == pytest.approx(50, abs=1)


def test_publishers_without_names_are_all_heard(topic: Topic) -> None:
    assert topic.go_on(1.0, sender=lambda number: "") == 50
    assert topic.lines() == ""
