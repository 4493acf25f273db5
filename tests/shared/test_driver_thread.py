"""The driving topic works in the thread that it arrives in: newest first, one at a time, and never unnoticed dead."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from shared.loop.process import Loop, StopRequest
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router
from tests.shared.busy_loop import BusyLoop
from tests.shared.runner_rig import Rig
from tests.support.wait import eventually


@pytest.fixture
def stop() -> Iterator[StopRequest]:
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    yield StopRequest()
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def buses(shared_router: Router) -> Iterator[tuple[ZenohBus, ZenohBus]]:
    pair = ZenohBus(connect=shared_router.endpoint), ZenohBus(connect=shared_router.endpoint)
    yield pair
    for bus in pair:
        bus.close()


@pytest.mark.processes
def test_what_arrives_during_the_work_is_handed_over_first_and_worked_on_once(
    buses: tuple[ZenohBus, ZenohBus],
) -> None:
    sender, receiver = buses
    heard: list[bytes] = []
    works: list[tuple[bool, bytes]] = []
    go_on = threading.Event()

    def work(behind: bool) -> None:
        works.append((behind, heard[-1]))
        go_on.wait(10.0)

    receiver.subscribe("stop", heard.append, work)
    eventually(lambda: sender.publish("stop", b"first") or works, message="the first work")
    passed: list[bytes] = []
    sender.subscribe("stop", passed.append)
    eventually(lambda: sender.publish("stop", b"probe") or b"probe" in passed)
    eventually(lambda: sender.publish("stop", b"newest") or b"newest" in passed)
    assert len(works) == 1
    go_on.set()
    eventually(lambda: len(works) > 1 and works[-1][1] == b"newest", message="work on the newest payload")
    assert works[1][0] and heard.index(b"probe") < heard.index(b"newest"), works


def test_a_sample_that_waited_for_the_work_before_counts_that_work_as_its_own_delay() -> None:
    loop = BusyLoop()
    loop.working()
    loop.cost = 0.062
    loop.run(1)
    loop.cost = 0.0
    for age in (0.05, 0.04, 0.03, 0.02, 0.01, 0.0):
        loop.deliver(age)
    loop.runner.poll(behind=True)
    assert loop.service.calls == ["step", "brake overrun"]


def test_a_failure_in_the_bus_thread_ends_the_loop_and_brakes(stop: StopRequest) -> None:
    rig = Rig()
    rig.working()
    loop = Loop(stop)

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
