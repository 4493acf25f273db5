"""A second process of a kind says who is first, and ends before it has said anything on the bus."""

from __future__ import annotations

import signal

import pytest

from shared.loop.door import BOTH_FOR, SECOND
from shared.processes import ROBOTS
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router
from tests.promises.conftest import Launch, Stage
from tests.promises.subjects import BY_NAME, SERVICES, Subject
from tests.promises.surroundings import PATIENCE, Surroundings
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def second(process: Process, first: str) -> None:
    """It ends with one line that names the first one."""
    assert process.wait(20.0) == SECOND, process.output
    *_, line = process.output.splitlines()  # a library may greet before it
    assert f"{first} runs already as tiago on tcp/" in line and "To take over" in line


@pytest.mark.parametrize("subject", SERVICES, ids=repr)
def test_the_second_one_is_told_and_the_first_one_works_on(
    subject: Subject, stage: Stage, around: Surroundings, launch: Launch
) -> None:
    sessions = {key: {one.header.session for one in said} for key, said in around.heard.items()}
    second(launch(subject, stage.endpoint), subject.process.known_as)
    if subject.name in ROBOTS:
        other = next(name for name in BY_NAME if name in ROBOTS and name != subject.name)
        second(launch(BY_NAME[other], stage.endpoint), subject.process.known_as)
    around.goes_on("a second one")
    for key, said in around.heard.items():
        assert {one.header.session for one in said} <= sessions[key] or not sessions[key]


def test_one_that_hung_while_another_took_its_place_leaves_or_stays_alone(
    launch: Launch, shared_router: Router
) -> None:
    bus = ZenohBus(connect=shared_router.endpoint)
    wrench = BY_NAME["wrench"]
    first = launch(wrench, shared_router.endpoint)
    eventually(lambda: bus.sessions("wrench"), PATIENCE, "the first one")
    first.signal(signal.SIGSTOP)
    other = launch(wrench, shared_router.endpoint)
    other.wait_for_output("wrench: waiting for sensor/ft")
    assert len(bus.sessions("wrench")) == 1
    first.signal(signal.SIGCONT)
    eventually(lambda: first.running != other.running, PATIENCE + BOTH_FOR, "one of them ends")
    eventually(lambda: len(bus.sessions("wrench")) == 1 and "wrench" in bus.living(), PATIENCE, "the other one stays")
    second_one = other if first.running else first
    assert second_one.wait() == SECOND and "runs already" in second_one.output
    bus.close()
