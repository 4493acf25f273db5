"""One topic's receiving end: order, sessions, silence, delay, loss and garbage, without any bus."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.faults import FaultKind
from shared.messages import LONGEST_TTL, Header, Stop, TwistCommand
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, MAP_CAP, SENSOR_FT, STOP, WRENCH_EXTERNAL
from shared.wire.subscription import HANDOVER_LIMIT, TOLD_FOR, Subscription
from tests.shared.rig import DECLARED_DELAY, ZERO, Feed, ManualClock, Publisher, ft_sample, target, wrench


def test_never_seen_then_healthy(feed: Feed) -> None:
    assert feed.fault() is FaultKind.NEVER_SEEN
    assert feed.subscription.age(feed.clock.now) == -1.0
    feed.run(1)
    assert feed.fault() is None
    assert feed.subscription.age(feed.clock.now) == 0.0


def test_duplicates_and_older_messages_are_dropped_and_counted(feed: Feed) -> None:
    feed.run(3)
    newest = feed.subscription.latest
    assert newest is not None
    feed.clock.advance(0.005)
    for seq in (2, 1, 0, 2):
        feed.offer(force=9.0, seq=seq)
    feed.offer(force=9.0, seq=3, stamp=newest.header.stamp - 1)
    assert feed.subscription.latest is newest
    assert feed.subscription.out_of_order == 5
    assert len(feed.received) == 3
    assert "5 out of sequence" in feed.subscription.refusals


@given(st.permutations(range(30)), st.lists(st.integers(0, 29), max_size=20))
@settings(max_examples=60, deadline=None)
def test_in_any_order_of_arrival_sequence_and_stamp_only_advance(order: list[int], again: list[int]) -> None:
    feed = Feed()
    payloads = []
    for _ in range(30):
        feed.clock.advance(0.01)
        payloads.append(feed.first.payload(ft_sample()))
    for seq in (*order, *again):
        feed.subscription.offer(payloads[seq])
    headers = [received.header for received in feed.received]
    assert all(a.seq < b.seq and a.stamp <= b.stamp for a, b in itertools.pairwise(headers))
    assert headers[-1].seq == 29
    assert feed.subscription.accepted + feed.subscription.out_of_order == 30 + len(again)


def test_a_second_session_is_refused_while_the_first_lives(feed: Feed) -> None:
    second = Publisher(feed.clock, session=2)
    feed.run(5)
    for _ in range(50):
        feed.run(1)
        feed.offer(second, force=99.0)
    assert feed.subscription.second_session == 50
    assert all(received.header.session == 1 for received in feed.received)
    assert "second session" in feed.subscription.refusals


def twist(ttl: float) -> Callable[[], TwistCommand]:
    return lambda: TwistCommand(ZERO, ZERO, ttl)


@pytest.mark.parametrize(
    ("feed", "held"),
    [
        (Feed(), 0.03),
        # A command holds its topic for its ttl.
        (Feed(COMMAND_EE_TWIST, twist(0.02)), 0.02),
        (Feed(COMMAND_EE_TWIST, twist(0.2)), 0.2),
        (Feed(COMMAND_EE_TWIST, twist(1e9)), LONGEST_TTL),
        # A target is used for ever, and can be handed over all the same.
        (Feed(CONTROL_TARGET, target, 0.2), HANDOVER_LIMIT),
    ],
    ids=lambda value: value.subscription.topic.key if isinstance(value, Feed) else value,
)
def test_a_second_session_takes_over_after_the_silence(feed: Feed, held: float) -> None:
    feed.run(3)
    second = Publisher(feed.clock, session=2)
    feed.clock.advance(held - 0.001)
    feed.subscription.offer(second.payload(feed.make()))
    assert feed.subscription.second_session == 1
    feed.clock.advance(0.002)
    feed.subscription.offer(second.payload(feed.make()))
    latest = feed.subscription.latest
    assert latest is not None and latest.header.session == 2
    feed.subscription.offer(feed.first.payload(feed.make()))
    assert (feed.subscription.second_session, feed.subscription.accepted) == (2, 4)
    assert feed.fault() is None


def test_anybody_may_stop_at_any_time() -> None:
    feed = Feed(STOP, lambda: Stop(False))
    feed.run(1)
    for session in range(2, 6):
        feed.subscription.offer(Publisher(feed.clock, session).payload(Stop(True, "me")))
    assert feed.subscription.accepted == 5 and feed.subscription.second_session == 0


def test_garbage_is_counted_and_changes_nothing_else(feed: Feed) -> None:
    feed.run(3)
    newest = feed.subscription.latest
    for payload in (b"", b"\xc1", b"\x80", bytes(MAP_CAP + 1), feed.first.payload(ft_sample())[:-1]):
        feed.subscription.offer(payload)
    assert feed.subscription.latest is newest
    assert feed.subscription.rejected == 5
    assert feed.fault() is None
    feed.clock.advance(0.05)
    assert feed.fault() is FaultKind.REFUSED


def test_nothing_but_garbage_is_told_from_nothing_at_all(feed: Feed) -> None:
    feed.subscription.offer(b"\x81\xa3seq\x01")
    fault = feed.subscription.fault(feed.clock.now, DECLARED_DELAY)
    assert fault is not None and fault.kind is FaultKind.REFUSED and "session is missing" in fault.text


def test_an_invalid_message_is_reported_with_the_publishers_word_and_no_more() -> None:
    clock = ManualClock()
    subscription = Subscription(WRENCH_EXTERNAL, clock)
    subscription.offer(Publisher(clock).payload(wrench(fault="stuck" + "!" * 5000), valid=False))
    fault = subscription.fault(clock.now, DECLARED_DELAY)
    assert fault is not None and fault.kind is FaultKind.INVALID
    assert fault.word.startswith("stuck!") and len(fault.text) < 200


@pytest.mark.parametrize("forward", ["seq", "stamp"])
def test_one_message_far_ahead_does_not_make_the_topic_deaf_for_ever(feed: Feed, forward: str) -> None:
    feed.run(50)
    seq = 2**62 if forward == "seq" else None
    stamp = feed.first.stamp() + 10**15 if forward == "stamp" else None
    feed.offer(seq=seq, stamp=stamp)
    feed.run(5)
    assert feed.subscription.accepted == 51
    feed.run(120)
    assert feed.fault() is None
    latest = feed.subscription.latest
    assert latest is not None and latest.header.seq == feed.first.seq - 1
    assert latest.delay < 0.001


def test_a_message_repeated_for_ever_never_counts_as_new(feed: Feed) -> None:
    feed.run(5)
    payload = feed.first.payload(ft_sample(), seq=3)
    for _ in range(300):
        feed.clock.advance(0.01)
        feed.subscription.offer(payload)
    assert feed.subscription.accepted == 5
    fault = feed.subscription.fault(feed.clock.now, DECLARED_DELAY)
    assert fault is not None and fault.kind is FaultKind.REFUSED
    assert "300 messages rejected, the last one: number 3 came after 4" in fault.text


def test_what_was_refused_long_ago_is_no_reason_for_silence(feed: Feed) -> None:
    feed.run(5)
    feed.subscription.offer(b"?")
    feed.clock.advance(0.5)
    assert feed.fault() is FaultKind.REFUSED
    feed.clock.advance(0.6)
    assert feed.fault() is FaultKind.SILENT
    stop = Subscription(STOP, feed.clock)
    stop.offer(b"?")
    assert stop.refused(feed.clock.now)
    feed.clock.advance(TOLD_FOR + 1.0)
    assert not stop.refused(feed.clock.now)


def test_who_publishes_beside_the_first_one_is_named_while_it_does(feed: Feed) -> None:
    feed.subscription = Subscription(SENSOR_FT, feed.clock, named={1: "sim"}.get)  # type: ignore[arg-type]
    feed.run(5)
    assert not feed.subscription.second(feed.clock.now)
    feed.offer(Publisher(feed.clock, session=2))
    assert feed.subscription.second(feed.clock.now) == ("session 2", "sim")
    feed.run(101)
    assert not feed.subscription.second(feed.clock.now)
    second = Publisher(feed.clock, session=3)
    feed.offer(second)
    feed.clock.advance(0.5)
    feed.offer(second)
    assert not feed.subscription.second(feed.clock.now), "it has taken over"


def test_threads_may_offer_at_once(feed: Feed) -> None:
    """Whatever the interleaving: each message is accepted once or counted as out of order, and the newest wins."""
    count, threads = 500, 4
    payloads = [feed.first.payload(ft_sample(), stamp=feed.first.stamp() + number) for number in range(count * threads)]
    barrier = threading.Barrier(threads)

    def offer(part: int) -> None:
        barrier.wait()
        for payload in payloads[part::threads]:
            feed.subscription.offer(payload)

    workers = [threading.Thread(target=offer, args=(part,)) for part in range(threads)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    latest = feed.subscription.latest
    assert latest is not None and latest.header.seq == count * threads - 1
    assert latest.number == feed.subscription.accepted == len(feed.received)
    assert feed.subscription.accepted + feed.subscription.out_of_order == count * threads


def test_headers_of_extreme_integers_do_no_harm(feed: Feed) -> None:
    for seq, session, stamp in ((0, 0, 2**64 - 1), (2**64 - 1, 0, 2**64 - 1), (5, 1, -(2**63)), (6, 1, 2**64 - 1)):
        feed.clock.advance(2.0)
        feed.offer(Publisher(feed.clock, session), seq=seq, stamp=stamp)
        feed.fault()
        assert np.isfinite(
            [feed.subscription.age(feed.clock.now), feed.subscription.loss(), feed.subscription.age_limit]
        ).all()
    assert feed.subscription.accepted == 4
    assert isinstance(feed.received[-1].header, Header)
