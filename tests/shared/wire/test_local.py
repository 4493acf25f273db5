"""Simulated time, and the bus inside one process."""

from __future__ import annotations

import pytest

from shared.wire.bus import NoReply
from shared.wire.local import LocalBus, Scheduler


def test_actions_run_in_the_order_of_their_times_and_ties_as_asked() -> None:
    scheduler = Scheduler()
    ran: list[tuple[str, int]] = []

    def note(name: str):
        return lambda: ran.append((name, scheduler.clock.now_ns()))

    scheduler.at(30, note("c"))
    scheduler.at(10, note("a"))
    scheduler.at(10, note("b"))
    scheduler.at(10, lambda: scheduler.soon(note("soon")))
    scheduler.run_until(20)
    assert ran == [("a", 10), ("b", 10), ("soon", 10)]
    assert scheduler.clock.now_ns() == 20
    scheduler.at(5, note("past"))
    scheduler.run_until(40)
    assert ran[3:] == [("past", 20), ("c", 30)]
    assert scheduler.clock.now_ns() == 40


def test_running_stops_as_soon_as_it_is_done() -> None:
    scheduler = Scheduler()
    ran: list[int] = []
    for time in (1, 2, 3):
        scheduler.at(time, lambda time=time: ran.append(time))
    scheduler.run_until(10, done=lambda: len(ran) == 2)
    assert ran == [1, 2] and scheduler.clock.now_ns() == 2


def test_payloads_arrive_after_the_latency_in_order_at_every_subscriber() -> None:
    scheduler = Scheduler()
    bus = LocalBus(scheduler, latency=0.004)
    got: list[tuple[str, bytes, int]] = []
    for name in ("x", "y"):
        bus.subscribe("a/b", lambda payload, name=name: got.append((name, payload, scheduler.clock.now_ns())))
    bus.publish("a/b", b"1")
    bus.publish("a/b", b"2")
    bus.publish("a/c", b"3")
    assert not got
    scheduler.run_until(10**7)
    due = 4_000_000
    assert got == [("x", b"1", due), ("y", b"1", due), ("x", b"2", due), ("y", b"2", due)]


def test_who_leaves_hears_nothing_more_and_the_others_do() -> None:
    scheduler = Scheduler()
    bus = LocalBus(scheduler)
    first: list[bytes] = []
    second: list[bytes] = []
    leave_first, leave_second = bus.listen("a/b", first.append), bus.listen("a/b", second.append)
    leave_first()
    bus.publish("a/b", b"1")
    scheduler.run_until(1)
    assert (first, second) == ([], [b"1"]) and bus.wanted("a/b")
    leave_second()
    assert not bus.wanted("a/b")
    bus.subscribe("a/b", first.append)
    bus.publish("a/b", b"2")
    scheduler.run_until(2)
    assert (first, second) == ([b"2"], [b"1"])


def test_a_query_that_is_answered_later_takes_its_time_and_no_more() -> None:
    scheduler = Scheduler()
    bus = LocalBus(scheduler)
    bus.serve("q", lambda payload, reply: scheduler.at(500_000_000, lambda: reply(payload * 2)))
    assert bus.query("q", b"ab", timeout=1.0) == b"abab"
    assert scheduler.clock.now_ns() == 500_000_000
    with pytest.raises(NoReply):
        bus.query("nobody", b"", timeout=1.0)
    bus.serve("mute", lambda payload, reply: None)
    with pytest.raises(NoReply, match="within 2 s"):
        bus.query("mute", b"", timeout=2.0)
    assert scheduler.clock.now_ns() == 2_500_000_000


def test_closing_forgets_everybody() -> None:
    bus = LocalBus(Scheduler())
    bus.alive("wrench", 7)
    bus.serve("q", lambda payload, reply: reply(b""))
    bus.close()
    assert bus.living() == set()
    assert not bus.query_later("q", b"", lambda reply: None)
