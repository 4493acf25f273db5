"""When a service took what: in the order in which it happened, from any thread, and bounded."""

from __future__ import annotations

import threading

from hypothesis import given
from hypothesis import strategies as st

from shared.loop.diary import BEGUN, DONE, TURN, TURN_BEHIND, Diary, entries, mark_of
from shared.topics import SENSOR_FT, STATE_EE, setup_topic
from shared.wire.codec import decode
from tests.shared.loop.rig import Rig

TIMES = st.integers(-(2**63), 2**63 - 1)


@given(times=st.lists(TIMES, min_size=4, max_size=4), payload=st.binary(max_size=50))
def test_what_was_noted_is_told_once_in_its_order(times: list[int], payload: bytes) -> None:
    diary = Diary(7)
    diary.input(STATE_EE.key)
    ft = diary.input(SENSOR_FT.key)
    ft(times[0], payload)
    diary.turn(times[1], behind=False)
    diary.turn(times[2], behind=True)
    diary.done(times[3])
    told = [tuple(entry) for entry in entries(diary.told())]
    assert told == [
        (BEGUN, 7, 0),
        (1, times[0], mark_of(payload)),
        (TURN, times[1], 0),
        (TURN_BEHIND, times[2], 0),
        (DONE, times[3], 0),
    ]
    assert diary.keys == [STATE_EE.key, SENSOR_FT.key] and diary.told() == b""


@given(told=st.binary(max_size=100))
def test_whatever_is_told_is_read_as_far_as_it_is_whole(told: bytes) -> None:
    assert len(list(entries(told))) == len(told) // 13


def test_nothing_is_lost_between_threads_and_memory_is_bounded() -> None:
    diary = Diary(0)
    note = diary.input(SENSOR_FT.key)
    each = 500
    threads = [threading.Thread(target=lambda: [note(number, b"x") for number in range(each)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    found: list[int] = []
    while any(thread.is_alive() for thread in threads):
        found += [entry.what for entry in entries(diary.told())]
    found += [entry.what for entry in entries(diary.told())]
    assert found.count(0) == 4 * each
    for number in range(20_000):
        note(number, b"x")
    kept = list(entries(diary.told()))
    assert len(kept) < 10_000 and kept[-1].time == 19_999


def test_a_full_diary_is_a_message_of_the_contract() -> None:
    rig = Rig()
    topic = setup_topic("recorder")
    told: list[bytes] = []
    rig.stack.bus.subscribe(topic.key, lambda payload: told.append(bytes(payload)))
    note = rig.runner._diary.input(SENSOR_FT.key)
    for number in range(20_000):
        note(number, b"x")
    rig.stack.run(1.0)
    assert told and all(decode(topic.message, payload, topic.cap) for payload in told)
    assert max(map(len, told)) > 100_000
