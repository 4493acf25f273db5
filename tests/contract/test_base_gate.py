"""The gate of a robot's base, from outside: the rules are those of its tool, but so much weight brakes in its time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from shared.messages import BaseTwistCommand
from shared.topics import COMMAND_BASE_TWIST, STATE_BASE
from tests.conftest import Router
from tests.contract.robot import PATIENCE, Commander, Robot
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

TURN = 0.2  # [rad/s]
FORWARD = 0.1  # [m/s]
WITHIN = 1.0
"""Time [s] within which a base that rolls slowly has come to rest."""


@pytest.fixture
def commander(shared_router: Router) -> Iterator[Commander]:
    commander = Commander(shared_router.endpoint, COMMAND_BASE_TWIST)
    yield commander
    commander.close()


@pytest.fixture
def second(shared_router: Router) -> Iterator[Commander]:
    commander = Commander(shared_router.endpoint, COMMAND_BASE_TWIST)
    yield commander
    commander.close()


def swaying(velocity: tuple[float, float, float], ttl: float = 0.1) -> Callable[[], BaseTwistCommand]:
    """A command that stays near where it began."""
    count = iter(range(10**9))
    return lambda: BaseTwistCommand(np.array(velocity) * (1 if (next(count) + 50) // 100 % 2 else -1), ttl)


def turns(robot: Robot) -> Callable[[], bool]:
    return lambda: abs(robot.base.velocity[2]) > 0.4 * TURN


def rolls(robot: Robot) -> Callable[[], bool]:
    return lambda: abs(robot.base.velocity[0]) > 0.4 * FORWARD


def test_silence_means_stop(robot: Robot, commander: Commander) -> None:
    expired = robot.counted("base commands expired")
    commander.make = swaying((0.0, 0.0, TURN))
    eventually(turns(robot), PATIENCE, "the base turns")
    commander.make = lambda: None
    robot.base_rests()
    eventually(lambda: robot.counted("base commands expired") > expired, PATIENCE, "it is told")
    throughout(robot.base_at_rest, 0.5, "the base stands")


def test_a_command_acts_for_its_ttl_and_no_longer(robot: Robot, commander: Commander) -> None:
    signs = iter([1.0, -1.0] * 1000)

    def moved_by_one_command() -> bool:
        robot.base_rests()
        start = robot.base.position
        command = BaseTwistCommand((next(signs) * FORWARD, 0.0, 0.0), 100.0)
        commander.put(COMMAND_BASE_TWIST.key, commander.payload(command))

        def distance() -> float:
            return float(np.linalg.norm(robot.base.position - start))

        throughout(lambda: distance() < FORWARD * WITHIN, 2.0, "it goes no further")
        assert robot.base_at_rest()
        return distance() > 1e-3

    # On a busy machine a command may come too late to act; not every one does.
    eventually(moved_by_one_command, PATIENCE, "one command moves the base")


def test_of_two_publishers_the_second_is_refused_and_named(
    robot: Robot, commander: Commander, second: Commander
) -> None:
    refused = robot.counted("second session")
    commander.make = swaying((0.0, 0.0, TURN))
    eventually(turns(robot), PATIENCE, "the first one turns the base")
    second.make = swaying((FORWARD, 0.0, 0.0))
    eventually(lambda: robot.counted("second session") > refused, PATIENCE, "the second one is named")
    assert COMMAND_BASE_TWIST.key in robot.status.reason
    commander.make = lambda: None
    eventually(rolls(robot), PATIENCE, "the second one, once the first is silent")


def test_a_command_that_is_marked_invalid_means_stop(robot: Robot, commander: Commander) -> None:
    command = swaying((0.0, 0.0, TURN))
    commander.make = command
    eventually(turns(robot), PATIENCE, "the base turns")
    commander.make = lambda: commander.payload(command(), valid=False)
    robot.base_rests()
    throughout(robot.base_at_rest, 0.5, "the base stands")


def test_what_is_no_command_moves_nothing_and_is_counted(robot: Robot, commander: Commander) -> None:
    robot.base_rests()
    rejected = robot.counted("rejected")
    start = robot.base
    commander.make = lambda: b"\xc1" * 50
    eventually(lambda: robot.counted("rejected") >= rejected + 5, PATIENCE, "it is counted")
    assert np.linalg.norm(robot.base.position - start.position) < 1e-3


def test_an_excess_is_clamped_and_told(robot: Robot, commander: Commander) -> None:
    clamped = robot.counted("base commands clamped")
    commander.make = swaying((0.0, 0.0, 1e6), ttl=1e6)
    eventually(lambda: robot.counted("base commands clamped") > clamped, PATIENCE, "the excess is told")
    eventually(turns(robot), PATIENCE, "it turns all the same")
    robot.heard[STATE_BASE.key].clear()
    eventually(lambda: len(robot.all(STATE_BASE)) > 40, PATIENCE, "a second of it")
    fastest = max(abs(heard.message.velocity[2]) for heard in robot.all(STATE_BASE))
    assert fastest <= 1.05 * robot.status.max_base[2]


def test_only_an_omnidirectional_base_goes_sideways(robot: Robot, commander: Commander) -> None:
    omni = robot.status.base_type == "omni"
    assert (robot.status.max_base[1] > 0.0) == omni
    clamped = robot.counted("base commands clamped")
    start = robot.base.position
    commander.make = swaying((0.0, FORWARD, 0.0))
    if omni:
        eventually(lambda: abs(robot.base.velocity[1]) > 0.4 * FORWARD, PATIENCE, "it goes sideways")
        return
    eventually(lambda: robot.counted("base commands clamped") > clamped, PATIENCE, "it is told")
    throughout(lambda: np.linalg.norm(robot.base.position - start) < 2e-3, 0.5, "it stays")


def test_a_stop_is_latched_for_the_base_too(robot: Robot, commander: Commander, second: Commander) -> None:
    commander.make = swaying((0.0, 0.0, TURN))
    eventually(turns(robot), PATIENCE, "the base turns")
    second.stop(True, "hand on the button")
    try:
        eventually(lambda: robot.status.mode == "stopped", PATIENCE, "the gate is stopped")
        robot.base_rests()
        throughout(robot.base_at_rest, 0.5, "no command moves it")
        second.stop(False, valid=False)
        throughout(robot.base_at_rest, 0.3, "nor after an invalid release")
    finally:
        second.stop(False)
    eventually(turns(robot), PATIENCE, "it turns after the release")
