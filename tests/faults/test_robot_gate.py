"""The gate of the simulated robot, from outside its process: whatever is commanded, by whomever."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator

import msgpack
import numpy as np
import pytest

from shared.bus_zenoh import ZenohBus
from shared.client import Client
from shared.messages import EndEffector, RobotStatus, Stop, TwistCommand
from shared.topics import COMMAND_EE_TWIST, STATE_EE, STATE_ROBOT, STOP
from tests.conftest import Router, StartProcess
from tests.support.wait import eventually, throughout

ZERO = (0.0, 0.0, 0.0)
PATIENCE = 30.0


class Commander:
    """A stranger or a controller: sends what ``make`` gives, again and again, until told otherwise."""

    def __init__(self, endpoint: str) -> None:
        self.bus = ZenohBus(connect=endpoint)
        self.client = Client(self.bus)
        self.make: Callable[[], TwistCommand | bytes | None] = lambda: None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.wait(0.01):
            command = self.make()
            if isinstance(command, bytes):
                self.bus.publish(COMMAND_EE_TWIST.key, command)
            elif command is not None:
                self.client.publish(COMMAND_EE_TWIST, command)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self.bus.close()


class Robot:
    """What the robot tells."""

    def __init__(self, client: Client) -> None:
        self._tool = client.watch(STATE_EE)
        self._status = client.watch(STATE_ROBOT)
        eventually(lambda: self._tool.latest and self._status.latest, PATIENCE, "the robot speaks")

    @property
    def tool(self) -> EndEffector:
        assert self._tool.latest is not None
        return self._tool.latest.message

    @property
    def status(self) -> RobotStatus:
        assert self._status.latest is not None
        return self._status.latest.message

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.tool.linear))

    def at_rest(self) -> bool:
        return self.speed < 2e-3

    def rests(self) -> None:
        eventually(self.at_rest, PATIENCE, "the tool stands still")


@pytest.fixture
def first(shared_router: Router) -> Iterator[Commander]:
    commander = Commander(shared_router.endpoint)
    yield commander
    commander.close()


@pytest.fixture
def second(shared_router: Router) -> Iterator[Commander]:
    commander = Commander(shared_router.endpoint)
    yield commander
    commander.close()


@pytest.fixture
def robot(shared_router: Router, start: StartProcess, first: Commander) -> Iterator[Robot]:
    process = start("services.sim", "--connect", shared_router.endpoint)
    robot = Robot(first.client)
    yield robot
    assert process.running, process.output
    assert "Traceback" not in process.output, process.output


def swaying(axis: int, speed: float = 0.05, ttl: float = 0.1) -> Callable[[], TwistCommand]:
    """A command that stays near where it began."""
    count = iter(range(10**9))

    def make() -> TwistCommand:
        linear = [0.0, 0.0, 0.0]
        linear[axis] = speed if next(count) // 50 % 2 else -speed
        return TwistCommand(linear, ZERO, ttl)

    return make


def test_of_two_publishers_the_second_is_refused_and_named(
    robot: Robot, first: Commander, second: Commander
) -> None:
    first.make = swaying(2)
    eventually(lambda: abs(robot.tool.linear[2]) > 0.02, PATIENCE, "the first one moves the tool")
    second.make = swaying(1)
    eventually(lambda: "second session" in robot.status.reason, PATIENCE, "the second one is named")
    first.make = lambda: None
    eventually(lambda: abs(robot.tool.linear[1]) > 0.02, PATIENCE, "the second one, once the first is silent")


@pytest.mark.parametrize(
    "command",
    [
        b"",
        b"\xc1" * 50,
        bytes(1_000_000),
        msgpack.packb({"linear": [math.nan] * 3, "angular": [0.0] * 3}),
        msgpack.packb(
            {
                "seq": 1,
                "session": 1,
                "stamp": 1,
                "valid": True,
                "linear": [math.inf, 0.0, 0.0],
                "angular": [0.0] * 3,
                "ttl": 0.1,
            }
        ),
    ],
    ids=["nothing", "garbage", "a megabyte", "no header", "infinite"],
)
def test_what_is_no_command_moves_nothing_and_is_counted(
    robot: Robot, first: Commander, command: bytes
) -> None:
    robot.rests()
    first.make = lambda: command
    eventually(lambda: f"{COMMAND_EE_TWIST.key}: " in robot.status.reason, PATIENCE, "it is counted")
    assert "rejected" in robot.status.reason
    throughout(robot.at_rest, 0.5, "the tool stands still")


def test_an_excess_is_clamped_and_told(robot: Robot, first: Commander) -> None:
    fastest = []

    def slow_enough() -> bool:
        fastest.append(robot.speed)
        return robot.speed <= robot.status.max_linear * 1.1

    first.make = swaying(2, speed=1e6, ttl=1e6)
    eventually(lambda: "clamped" in robot.status.reason, PATIENCE, "the excess is told")
    throughout(slow_enough, 1.0, "no faster than the robot's limit")
    assert max(fastest) > 0.02


def test_a_stop_is_latched_whatever_is_commanded_and_whoever_comes_and_goes(
    robot: Robot, first: Commander, second: Commander, shared_router: Router
) -> None:
    first.make = swaying(2)
    eventually(lambda: robot.speed > 0.02, PATIENCE, "the tool moves")
    second.client.publish(STOP, Stop(True, "hand on the button"))
    eventually(lambda: robot.status.mode == "stopped", PATIENCE, "the gate is stopped")
    assert "hand on the button" in robot.status.reason
    robot.rests()
    successor = Commander(shared_router.endpoint)
    try:
        first.make = lambda: None
        successor.make = swaying(2)
        throughout(robot.at_rest, 0.5, "another controller does not move it either")
        assert robot.status.mode == "stopped"
        second.client.publish(STOP, Stop(False, ""))
        eventually(lambda: robot.speed > 0.02, PATIENCE, "it moves after the release")
    finally:
        successor.close()


def test_silence_means_stop(robot: Robot, first: Commander) -> None:
    first.make = swaying(2)
    eventually(lambda: robot.speed > 0.02, PATIENCE, "the tool moves")
    first.make = lambda: None
    robot.rests()
    eventually(lambda: robot.status.mode == "holding", PATIENCE, "the gate holds")
    assert "expired" in robot.status.reason
