"""Whose turn it is: who was first is left alone, of two that begin together one goes on, a pause begins anew."""

from __future__ import annotations

import pytest

from shared.topics import CONTROL_TARGET
from shared.wire.client import Client
from shared.wire.local import LocalBus, Scheduler
from shared.wire.turn import Turn
from tests.shared.rig import target


class Room:
    """Two participants and simulated time; each asks ten times a second, and publishes if ``speaks`` says so."""

    def __init__(self) -> None:
        self.scheduler = Scheduler()
        self.bus = LocalBus(self.scheduler)
        self.clients: dict[str, Client] = {}
        self.turns: dict[str, Turn] = {}

    def enter(self, name: str) -> Turn:
        client = self.clients[name] = Client(self.bus, self.scheduler.clock, name)
        turn = self.turns[name] = client.publisher.share(CONTROL_TARGET)
        return turn

    def run(self, duration: float, *speakers: str) -> None:
        for _ in range(round(duration / 0.1)):
            for turn in self.turns.values():
                turn.taken()
            for name in speakers:
                self.clients[name].publish(CONTROL_TARGET, target())
            self.scheduler.run_until(self.scheduler.clock.now_ns() + 100_000_000)


@pytest.mark.parametrize("listens", [0.3, 1.0] * 4)  # whichever session is the lower
def test_who_comes_second_is_told_who_is_first_and_the_first_one_goes_on(listens: float) -> None:
    room = Room()
    first = room.enter("hold")
    room.run(3.0, "hold")
    second = room.enter("identify")
    room.run(listens, "hold")
    assert second.taken() == "hold" and not first.taken()
    room.run(2.0, "hold", "identify")
    assert second.taken() == "hold" and not first.taken(), "also if it does not care"
    room.run(1.5, "identify")
    assert not second.taken(), "the first one is silent"


def test_one_that_did_not_listen_before_is_second_to_whoever_is_there() -> None:
    for name in ("a", "b", "c", "d"):
        room = Room()
        room.enter("hold")
        room.run(3.0, "hold")
        impolite = room.enter(name)
        room.run(0.4, name, "hold")
        assert impolite.taken() == "hold" and not room.turns["hold"].taken()


def test_of_two_that_begin_together_the_lower_session_goes_on() -> None:
    room = Room()
    turns = [room.enter("a"), room.enter("b")]
    room.run(1.0)
    assert all(turn.listened and not turn.taken() for turn in turns)
    room.run(0.5, "a", "b")
    lower = min(room.clients, key=lambda name: room.clients[name].publisher.session)
    assert {name: turn.taken() for name, turn in room.turns.items()} == {
        name: "" if name == lower else lower for name in "ab"
    }


def test_after_a_pause_it_listens_again() -> None:
    room = Room()
    first = room.turns["hold"] = room.enter("hold")
    room.run(2.0, "hold")
    assert first.listened
    del room.turns["hold"]  # not run any more, as a process that is stopped
    room.enter("task")
    room.run(2.0, "task")
    assert first.taken() == "task" and not first.listened
    room.turns["hold"] = first
    room.run(1.0, "task", "hold")
    assert first.taken() == "task" and not room.turns["task"].taken()


def test_what_is_no_message_is_nobody() -> None:
    room = Room()
    turn = room.enter("hold")
    for _ in range(5):
        room.bus.publish(CONTROL_TARGET.key, b"?")
        room.run(0.1)
    assert not turn.taken()
