"""A process is killed, hangs or is started again, and so is the router: the rest brakes, and resumes by itself."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from shared.topics import CONTROL_TARGET, health_topic
from tests.faults.chain import PATIENCE, Chain
from tests.support.processes import Process
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes


@pytest.fixture
def robot(chain: Chain) -> Iterator[Process]:
    with chain.playing() as program:
        yield program


def silent(chain: Chain) -> None:
    """No command comes any more; a gate brakes by itself then."""

    def quiet() -> bool:
        count = len(chain.watch.commands)
        try:
            throughout(lambda: len(chain.watch.commands) == count, 0.3)
        except AssertionError:
            return False
        return True

    eventually(quiet, PATIENCE, "no command any more")


def test_a_killed_controller_is_missed_and_its_successor_resumes(chain: Chain, robot: Process) -> None:
    before = chain.watch.commands[-1].session
    chain.controller.kill()
    silent(chain)
    eventually(lambda: "controller" not in chain.bus.living(), PATIENCE, "it is shown as lost")
    first = len(chain.watch.commands)
    chain.controller = chain.start_controller()
    chain.works("the new one moves the tool")
    successors = chain.watch.commands[first:]
    assert {command.session for command in successors} != {before}
    assert not successors[0].moves  # it brakes before it moves


def test_a_hung_controller_is_missed_and_goes_on_when_it_wakes(chain: Chain, robot: Process) -> None:
    chain.controller.signal(signal.SIGSTOP)
    silent(chain)
    eventually(lambda: "controller" not in chain.bus.living(), PATIENCE, "it is shown as lost")
    first = len(chain.watch.commands)
    chain.controller.signal(signal.SIGCONT)
    chain.works("the woken one moves the tool")
    # One may have been on its way when it was stopped; then it brakes for the start-up time.
    assert not any(command.moves for command in chain.watch.commands[first + 1 : first + 4])


def test_a_stopped_controller_brakes_before_it_ends(chain: Chain, robot: Process) -> None:
    chain.controller.signal(signal.SIGTERM)
    assert chain.controller.wait() == 0
    eventually(lambda: not chain.watch.commands[-1].moves, PATIENCE, "the last command brakes")
    chain.controller = chain.start_controller()
    chain.works("the new one moves the tool")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_lost_wrench_service_brakes(chain: Chain, robot: Process, number: signal.Signals) -> None:
    chain.wrench.signal(number)
    chain.brakes()
    assert "wrench" in chain.watch.reason
    if number == signal.SIGKILL:
        chain.wrench.wait()
        chain.wrench = chain.start_wrench()
    else:
        chain.wrench.signal(signal.SIGCONT)
    chain.works("it resumes by itself")


def test_the_last_target_stays_in_force(chain: Chain, robot: Process) -> None:
    """The task may die: its last target holds, as the contract says."""
    subscription = chain.client.watch(CONTROL_TARGET)
    eventually(lambda: subscription.latest, PATIENCE, "a target")
    chain.paused = True
    try:
        chain.works("the tool moves without a task")
    finally:
        chain.paused = False


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_lost_router_stops_everything_and_needs_nobody_when_it_is_back(
    own_chain: Chain, number: signal.Signals
) -> None:
    chain = own_chain
    with chain.playing():
        router = chain.router.process
        router.signal(number)
        if number == signal.SIGKILL:
            router.wait()
        silent(chain)
        if number == signal.SIGKILL:
            chain.replace_router()
        else:
            router.signal(signal.SIGCONT)
        chain.works("it resumes by itself")
        assert "latched" not in chain.watch.reason


def test_health_of_a_service_that_starts_alone_says_what_it_waits_for(chain: Chain) -> None:
    chain.brakes()
    health = chain.client.watch(health_topic("controller"))
    eventually(lambda: health.latest and health.latest.message.state != "ok", PATIENCE, "no more ok")
    assert health.latest is not None
    assert "Is robot running?" in health.latest.message.detail or "wrench" in health.latest.message.detail
