"""A process waits for what is not there, comes back with it, and ends within 2 s of a signal whatever is there."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.promises.conftest import Launch
from tests.promises.subjects import SERVICES, SUBJECTS, Subject
from tests.promises.surroundings import PATIENCE, Surroundings
from tests.support.ports import free_endpoint
from tests.support.processes import Process
from tests.support.stand_in import silently
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

every_service = pytest.mark.parametrize("subject", SERVICES, ids=repr)
working = pytest.mark.parametrize("subject", [s for s in SERVICES if s.name != "experiment"], ids=repr)
"""An experiment is played once, and not begun again."""


def hears(process: Process, number: signal.Signals) -> bool:
    """Whether the process handles a signal already."""
    status = dict(line.split(":\t") for line in Path(f"/proc/{process.pid}/status").read_text().splitlines())
    return bool(int(status["SigCgt"], 16) >> (number - 1) & 1)


def moves(subject: Subject) -> bool:
    """Whether the robot does what the subject says."""
    return subject.output is not None and subject.output.key.startswith("command/")


@pytest.mark.parametrize("subject", [s for s in SUBJECTS if s.name != "cli"], ids=repr)
def test_ends_while_it_is_still_starting(subject: Subject, launch: Launch) -> None:
    process = launch(subject, free_endpoint())
    eventually(lambda: hears(process, signal.SIGTERM), message="a handler")
    process.ends_in_time()


@every_service
def test_ends_while_it_waits_for_a_router(subject: Subject, launch: Launch) -> None:
    endpoint = free_endpoint()
    process = launch(subject, endpoint)
    process.wait_for_output(f"{subject.name}: waiting for a Zenoh router at {endpoint}")
    process.ends_in_time(signal.SIGINT)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=["SIGTERM", "SIGINT"])
def test_the_router_ends_with_clients_connected(router: Router, number: signal.Signals) -> None:
    client = ZenohBus(connect=router.endpoint)
    try:
        router.process.ends_in_time(number)
    finally:
        client.close()


@every_service
def test_ends_while_nobody_else_is_there(subject: Subject, launch: Launch, shared_router: Router) -> None:
    process = launch(subject, shared_router.endpoint)
    watcher = ZenohBus(connect=shared_router.endpoint)
    eventually(lambda: subject.process.known_as in watcher.living(), PATIENCE, "alive")
    process.ends_in_time()
    eventually(lambda: subject.process.known_as not in watcher.living(), PATIENCE, "no more alive")
    watcher.close()


@every_service
def test_ends_while_its_router_hangs(subject: Subject, launch: Launch, router: Router) -> None:
    process = launch(subject, router.endpoint)
    watcher = ZenohBus(connect=router.endpoint)
    eventually(lambda: subject.process.known_as in watcher.living(), PATIENCE, "alive")
    router.process.signal(signal.SIGSTOP)
    process.ends_in_time()
    watcher.close()
    router.process.signal(signal.SIGCONT)


@working
def test_says_what_is_missing_in_whatever_order_it_comes_and_ends_with_a_last_word(
    subject: Subject, launch: Launch, shared_router: Router
) -> None:
    with Surroundings(shared_router.endpoint, subject) as around:
        around.spoil.update({topic.key: silently for topic in subject.required})
        process = launch(subject, shared_router.endpoint)
        for topic in subject.required:
            around.names(f"waiting for {topic.key}: never received. Is {topic.publisher} running?")
            throughout(lambda: not around.works(), 0.3, f"no work without {topic.key}")
            del around.spoil[topic.key]
        around.begun()
        process.ends_in_time(signal.SIGINT)
        said = around.heard[(subject.last_word or subject.output).key]
        eventually(lambda: not said[-1].header.valid, message="a last word")
        if moves(subject):
            assert subject.rests(around.said(subject.output))
        around.unharmed()


@working
def test_comes_after_its_router_and_comes_back_with_it(subject: Subject, launch: Launch, start: StartProcess) -> None:
    endpoint = free_endpoint()
    process = launch(subject, endpoint)
    process.wait_for_output(f"waiting for a Zenoh router at {endpoint}")
    router = start("services.router", "--listen", endpoint)
    with Surroundings(endpoint, subject) as around:
        around.begun()
        router.kill()
        eventually(lambda: not around.works(), PATIENCE, "nothing is heard")
        router = start("services.router", "--listen", endpoint)
        around.goes_on("the router's restart")
        router.kill()
        process.ends_in_time()


@working
def test_killed_and_started_again_it_goes_on_from_rest(subject: Subject, launch: Launch, shared_router: Router) -> None:
    with Surroundings(shared_router.endpoint, subject) as around:
        first = launch(subject, shared_router.endpoint)
        around.begun()
        first.kill()
        said = around.heard[subject.output.key]
        said.clear()
        launch(subject, shared_router.endpoint)
        around.begun()
        if moves(subject):
            assert not said[0].header.valid and subject.rests(said[0].message)
        around.unharmed()
