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
lost = pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "hung"])


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


@lost
def test_a_lost_controller_is_missed_and_brakes_before_it_moves_again(
    chain: Chain, robot: Process, number: signal.Signals
) -> None:
    before = chain.watch.commands[-1].session
    chain.lose("controller", number)
    silent(chain)
    eventually(lambda: "controller" not in chain.bus.living(), PATIENCE, "it is shown as lost")
    first = len(chain.watch.commands)
    chain.bring_back("controller", number)
    chain.works("it moves the tool again")
    commands = chain.watch.commands[first:]
    if number == signal.SIGKILL:
        assert {command.session for command in commands} != {before}
        assert not commands[0].moves
    # One may have been on its way when it was hung; then it brakes for the start-up time.
    assert not any(command.moves for command in commands[1:4])


def test_a_stopped_controller_brakes_before_it_ends(chain: Chain, robot: Process) -> None:
    chain.controller.signal(signal.SIGTERM)
    assert chain.controller.wait() == 0
    eventually(lambda: not chain.watch.commands[-1].moves, PATIENCE, "the last command brakes")
    chain.controller = chain.start("controller")
    chain.works("the new one moves the tool")


@lost
def test_a_lost_wrench_service_brakes(chain: Chain, robot: Process, number: signal.Signals) -> None:
    chain.lose("wrench", number)
    chain.brakes()
    assert "wrench" in chain.watch.reason
    chain.bring_back("wrench", number)
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


@lost
def test_a_lost_router_stops_everything_and_needs_nobody_when_it_is_back(
    own_chain: Chain, number: signal.Signals
) -> None:
    with own_chain.playing():
        own_chain.lose("router", number)
        silent(own_chain)
        own_chain.bring_back("router", number)
        own_chain.works("it resumes by itself")
        assert "latched" not in own_chain.watch.reason


def test_health_of_a_service_that_starts_alone_says_what_it_waits_for(chain: Chain) -> None:
    chain.brakes()
    health = chain.client.watch(health_topic("controller"))
    eventually(lambda: health.latest and health.latest.message.state != "ok", PATIENCE, "no more ok")
    assert health.latest is not None
    assert "Is robot running?" in health.latest.message.detail or "wrench" in health.latest.message.detail
