"""What makes a process of a service: its signals, and the thread in which its driving topic arrives."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.loop import process
from shared.loop.process import Loop, StopRequest
from shared.parameters import Refused
from tests.shared.loop.rig import Rig
from tests.support.ports import free_port
from tests.support.wait import eventually

pytestmark = pytest.mark.usefixtures("as_a_process")


def test_a_signal_never_waits_for_the_lock_of_the_event_that_it_interrupts() -> None:
    """A handler that sets the event deadlocks within seconds here: the signals hit the event's own methods."""
    stop, done = StopRequest(), threading.Event()

    def pepper() -> None:
        while not done.is_set():
            os.kill(os.getpid(), signal.SIGTERM)

    peppering = threading.Thread(target=pepper)
    peppering.start()
    try:
        for _ in range(20_000):
            stop.wake.wait(0.0)
            stop.wake.clear()
        assert stop.requested
    finally:
        done.set()
        peppering.join()


def test_a_failure_in_the_bus_thread_ends_the_loop_and_brakes(rig: Rig) -> None:
    loop = Loop(StopRequest())

    def fail(behind: bool = False) -> None:
        raise RuntimeError("a defect")

    def work() -> None:
        eventually(lambda: loop._runner is not None)
        rig.runner.poll = fail  # type: ignore[method-assign]
        loop.on_driver(False)

    thread = threading.Thread(target=work)
    thread.start()
    with pytest.raises(RuntimeError, match="a defect"):
        loop.run(rig.runner)
    thread.join()
    assert rig.service.brakes


def test_what_a_service_holds_is_let_go_of_even_if_it_never_got_onto_the_bus(monkeypatch: pytest.MonkeyPatch) -> None:
    class Held(MockRobot):
        closed = 0

        def close(self) -> None:
            Held.closed += 1

    def refuse(_: MockParameters) -> MockRobot:
        raise Refused("no such robot")

    monkeypatch.setattr(process, "told_waiting", lambda *_: lambda: True)
    nobody = ["--connect", f"tcp/127.0.0.1:{free_port()}"]
    process.run(Held, MockParameters, "mock", nobody)
    assert Held.closed == 1
    assert process.run(refuse, MockParameters, "mock", nobody) == 2
