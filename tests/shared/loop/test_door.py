"""One of a kind enters, however many come at once; who is second is told who is first."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from shared.loop.door import BOTH_FOR, LEASE_OVER, Door, Occupied
from shared.wire.bus import Bus
from shared.wire.local import LocalBus, Scheduler
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router
from tests.support.wait import eventually, throughout


@pytest.fixture
def buses(shared_router: Router) -> Iterator[list[ZenohBus]]:
    opened = [ZenohBus(connect=shared_router.endpoint) for _ in range(5)]
    yield opened
    for bus in opened:
        bus.close()


def never() -> bool:
    return False


def tries(bus: Bus, name: str, session: int) -> str:
    """What a start is told at the door, empty if it enters."""
    try:
        Door(bus, name, session, "here").enter(never)
    except Occupied as problem:
        return str(problem)
    return ""


@pytest.mark.processes
def test_of_many_that_come_at_once_one_enters(buses: list[ZenohBus]) -> None:
    together = threading.Barrier(len(buses))
    told: dict[int, str] = {}

    def come(bus: ZenohBus, session: int) -> None:
        together.wait()
        told[session] = tries(bus, "wrench", session)

    comers = [threading.Thread(target=come, args=row) for row in zip(buses, (50, 20, 40, 10, 30), strict=True)]
    for comer in comers:
        comer.start()
    for comer in comers:
        comer.join()
    (first,) = (session for session, text in told.items() if not text)
    assert all(f"session {first}" in text for session, text in told.items() if session != first), told
    assert buses[0].sessions("wrench") == {first}


@pytest.mark.processes
def test_a_second_one_enters_as_soon_as_the_first_one_is_gone(buses: list[ZenohBus]) -> None:
    first, second = buses[:2]
    leave = first.claim("base", 1)
    told: list[str] = []
    waiting = threading.Thread(target=lambda: told.append(tries(second, "base", 2)))
    waiting.start()
    throughout(lambda: not told, LEASE_OVER / 4, "it waits")
    leave()
    waiting.join()
    assert told == [""]
    eventually(lambda: first.present() == {2: "base"}, message="the others are told")


@pytest.mark.parametrize(("there", "comes"), [("mock", "sim"), ("robot", "sim"), ("sim", "robot"), ("task", "task")])
def test_one_process_stands_for_a_kind(there: str, comes: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shared.loop.door.LEASE_OVER", 0.0)
    bus = LocalBus(Scheduler())
    bus.alive(there, 5)
    assert tries(bus, comes, 3).startswith(f"{there} runs already here (session 5)")
    assert bus.sessions(comes) == ({5} if comes == there else set()), "it leaves nothing behind"
    assert tries(bus, "wrench", 9) == "", "another kind"


@pytest.mark.parametrize("other", [4, 6])
def test_of_two_that_are_in_the_lower_session_stays(other: int, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("shared.loop.door.time.monotonic", lambda: now)
    bus = LocalBus(Scheduler())
    door = Door(bus, "wrench", 5, "here")
    door.enter(never)
    leave = bus.claim("wrench", other)
    assert not door.gives_way()
    now += BOTH_FOR - 0.1
    assert not door.gives_way(), "the other one may be waiting at the door"
    leave()
    assert not door.gives_way()
    bus.claim("wrench", other)
    now += 0.2
    assert not door.gives_way()
    now += BOTH_FOR + 0.1
    assert bool(door.gives_way()) == (other < 5)
