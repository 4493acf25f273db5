"""A service as a process: in any order of starting, with and without a router, it ends in time and with status 0."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from shared.loop.process import StopRequest
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

SIGNALS = pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=["SIGTERM", "SIGINT"])


@SIGNALS
def test_it_ends_while_it_waits_for_a_router(start: StartProcess, number: signal.Signals) -> None:
    endpoint = free_endpoint()
    process = start("services.wrench", "--connect", endpoint)
    process.wait_for_output(f"waiting for a Zenoh router at {endpoint}")
    process.ends_in_time(number)


@SIGNALS
def test_it_ends_while_it_is_connected(router: Router, start: StartProcess, number: signal.Signals) -> None:
    process = start("services.wrench", "--connect", router.endpoint)
    process.wait_for_output("waiting for sensor/ft")
    process.ends_in_time(number)


def test_it_ends_after_the_router_has_gone(router: Router, start: StartProcess) -> None:
    process = start("services.wrench", "--connect", router.endpoint)
    process.wait_for_output("waiting for sensor/ft")
    router.process.kill()
    process.ends_in_time()


ORDERS = (
    ("router", "wrench", "controller"),
    ("controller", "router", "wrench"),
    ("wrench", "controller", "router"),
)


@pytest.mark.parametrize("order", ORDERS, ids="-".join)
def test_any_start_order(start: StartProcess, order: tuple[str, ...]) -> None:
    endpoint = free_endpoint()
    processes = []
    for name in order:
        option = "--listen" if name == "router" else "--connect"
        process = start(f"services.{name}", option, endpoint)
        if name == "router":
            process.wait_for_output("listening")
        elif "router" not in order[: len(processes)]:
            process.wait_for_output("waiting for a Zenoh router")
        processes.append(process)
    watcher = ZenohBus(connect=endpoint)
    try:
        eventually(lambda: watcher.living() == {"wrench", "controller"}, 30.0, "both services alive")
    finally:
        watcher.close()
    for process in processes:
        process.ends_in_time()


@pytest.mark.parametrize("service", ["wrench", "controller", "base", "sim"])
def test_a_bad_setting_is_one_line_and_status_2(start: StartProcess, service: str) -> None:
    process = start(f"services.{service}", "--set", "no_such_parameter=1")
    assert process.wait(20.0) == 2
    (line,) = process.output.splitlines()
    assert line.startswith(f"{service}: --set: no_such_parameter is no parameter; there are ")


def test_a_signal_never_waits_for_the_lock_of_the_event_that_it_interrupts() -> None:
    """A handler that sets the event deadlocks within seconds here: the signals hit the event's own methods."""
    kept = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    done = threading.Event()

    def pepper() -> None:
        while not done.is_set():
            os.kill(os.getpid(), signal.SIGTERM)

    peppering = threading.Thread(target=pepper)
    try:
        stop = StopRequest()
        peppering.start()
        for _ in range(20_000):
            stop.wake.wait(0.0)
            stop.wake.clear()
        assert stop.requested
    finally:
        done.set()
        peppering.join()
        for number, handler in kept.items():
            signal.signal(number, handler)
