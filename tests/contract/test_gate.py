"""The gate of a robot process, from outside: whatever is commanded, by whomever."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable

import msgpack
import numpy as np
import pytest

from shared.messages import GripperCommand, HeadCommand, TwistCommand
from shared.schema.records import Record
from shared.topics import COMMAND_EE_TWIST, COMMAND_GRIPPER, COMMAND_HEAD, Topic
from tests.contract.robot import PATIENCE, ZERO, Commander, Robot
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes

SPEED = 0.05


def swaying(axis: int, speed: float = SPEED, ttl: float = 0.1) -> Callable[[], TwistCommand]:
    """A command that stays near where it began."""
    count = iter(range(10**9))

    def make() -> TwistCommand:
        linear = [0.0, 0.0, 0.0]
        linear[axis] = speed if (next(count) + 25) // 50 % 2 else -speed
        return TwistCommand(linear, ZERO, ttl)

    return make


def moves(robot: Robot, axis: int) -> Callable[[], bool]:
    return lambda: abs(robot.tool.linear[axis]) > 0.4 * SPEED


def test_silence_means_stop(robot: Robot, commander: Commander) -> None:
    expired = robot.counted("expired")
    commander.make = swaying(2)
    eventually(moves(robot, 2), PATIENCE, "the tool moves")
    eventually(lambda: robot.status.mode == "ready", PATIENCE, "the robot says so")
    commander.make = lambda: None
    robot.rests()
    eventually(lambda: robot.status.mode == "holding", PATIENCE, "the gate holds")
    eventually(lambda: robot.counted("expired") == expired + 1, PATIENCE, "it is counted once")
    where = robot.tool.position
    throughout(lambda: np.linalg.norm(robot.tool.position - where) < 1e-3, 0.5, "the tool stays")


@pytest.mark.parametrize(("ttl", "acts"), [(0.02, 0.02), (0.1, 0.1), (100.0, 0.2)])
def test_a_command_acts_for_its_ttl_and_no_longer(
    robot: Robot, commander: Commander, ttl: float, acts: float
) -> None:
    allowed = SPEED * acts
    signs = itertools.cycle((-1.0, 1.0))

    def moved_by_one_command() -> bool:
        robot.rests()
        start = robot.tool.position
        linear = (0.0, 0.0, next(signs) * SPEED)
        commander.put(COMMAND_EE_TWIST.key, commander.payload(TwistCommand(linear, ZERO, ttl)))

        def distance() -> float:
            return float(np.linalg.norm(robot.tool.position - start))

        throughout(lambda: distance() < 1.1 * allowed + 3e-4, 0.6, "it goes no further")
        return distance() > 0.3 * allowed

    # On a busy machine a command may come too late to act for so long, or at all; not every one does.
    eventually(moved_by_one_command, PATIENCE, "one command moves the tool")


def test_commands_slower_than_their_ttl_flood_nobody(robot: Robot, commander: Commander) -> None:
    turn = iter(range(10**9))
    command = swaying(2, ttl=0.02)
    expired = robot.counted("expired")
    commander.make = lambda: command() if next(turn) % 3 == 0 else None
    eventually(moves(robot, 2), PATIENCE, "the tool moves")
    before = robot.heard["state/robot"][-1].header
    eventually(lambda: robot.heard["state/robot"][-1].header.seq >= before.seq + 8, PATIENCE, "eight reports")
    after = robot.heard["state/robot"][-1].header
    assert (after.seq - before.seq) / ((after.stamp - before.stamp) * 1e-9) < 12.0
    assert robot.counted("expired") <= expired + 2


def test_of_two_publishers_the_second_is_refused_and_named(
    robot: Robot, commander: Commander, second: Commander
) -> None:
    refused = robot.counted("second session")
    commander.make = swaying(2)
    eventually(moves(robot, 2), PATIENCE, "the first one moves the tool")
    second.make = swaying(1)
    eventually(lambda: robot.counted("second session") > refused, PATIENCE, "the second one is named")
    commander.make = lambda: None
    eventually(moves(robot, 1), PATIENCE, "the second one, once the first is silent")


def test_what_is_out_of_sequence_is_not_executed_and_named(robot: Robot, commander: Commander) -> None:
    robot.rests()
    refused = robot.counted("out of sequence")
    turn = iter(range(10**9))
    commander.number = 1000

    def make() -> TwistCommand | bytes:
        if next(turn) % 2:
            return TwistCommand(ZERO, ZERO, 0.1)
        return commander.payload(TwistCommand((0, 0, -SPEED), ZERO, 0.2), number=10)

    # The first one sets the sequence; what is behind it is old.
    commander.put(COMMAND_EE_TWIST.key, commander.payload(TwistCommand(ZERO, ZERO, 0.1)))
    commander.make = make
    start = robot.tool.position
    eventually(lambda: robot.counted("out of sequence") >= refused + 5, PATIENCE, "it is counted")
    assert np.linalg.norm(robot.tool.position - start) < 1e-3


HEADER = {"seq": 1, "session": 1, "stamp": 1, "valid": True}
TWIST = {"linear": [0.05, 0.0, 0.0], "angular": [0.0] * 3, "ttl": 0.1}


@pytest.mark.parametrize(
    "command",
    [
        b"",
        b"\xc1" * 50,
        bytes(1_000_000),
        msgpack.packb(TWIST),
        msgpack.packb(HEADER | TWIST | {"linear": [math.nan, 0.0, 0.0]}),
        msgpack.packb(HEADER | TWIST | {"angular": [0.0, math.inf, 0.0]}),
        msgpack.packb(HEADER | TWIST | {"linear": [0.05, 0.0]}),
        msgpack.packb(HEADER | TWIST | {"ttl": "long"}),
        msgpack.packb(HEADER | {"angular": [0.0] * 3, "ttl": 0.1}),
    ],
    ids=[
        "nothing",
        "garbage",
        "a megabyte",
        "no header",
        "NaN",
        "infinite",
        "shape",
        "type",
        "field missing",
    ],
)
def test_what_is_no_command_moves_nothing_and_is_counted(
    robot: Robot, commander: Commander, command: bytes
) -> None:
    robot.rests()
    start = robot.tool.position
    rejected = robot.counted("rejected")
    commander.make = lambda: command
    eventually(lambda: robot.counted("rejected") >= rejected + 5, PATIENCE, "it is counted")
    assert np.linalg.norm(robot.tool.position - start) < 1e-3


def test_an_unknown_field_is_ignored(robot: Robot, commander: Commander) -> None:
    command = swaying(2)
    commander.make = lambda: msgpack.packb(msgpack.unpackb(commander.payload(command())) | {"colour": "red"})
    eventually(moves(robot, 2), PATIENCE, "the tool moves")


def test_a_command_that_is_marked_invalid_means_stop(robot: Robot, commander: Commander) -> None:
    command = swaying(2)
    commander.make = command
    eventually(moves(robot, 2), PATIENCE, "the tool moves")
    commander.make = lambda: commander.payload(command(), valid=False)
    robot.rests()
    throughout(robot.at_rest, 0.5, "the tool stands still")


def test_an_excess_is_clamped_and_told(robot: Robot, commander: Commander) -> None:
    clamped = robot.counted("clamped")
    fastest = []

    def slow_enough() -> bool:
        fastest.append(robot.speed)
        return robot.speed <= robot.status.max_linear * 1.1

    commander.make = swaying(2, speed=1e6, ttl=1e6)
    eventually(lambda: robot.counted("clamped") > clamped, PATIENCE, "the excess is told")
    throughout(slow_enough, 1.0, "no faster than the robot's limit")
    assert max(fastest) > 0.02


@pytest.mark.parametrize(
    ("topic", "message"),
    [(COMMAND_GRIPPER, GripperCommand(5.0, 1e3)), (COMMAND_HEAD, HeadCommand(9.0, 9.0))],
    ids=["gripper", "head"],
)
def test_what_gripper_and_head_cannot_do_or_read_is_told(
    robot: Robot, commander: Commander, topic: Topic, message: Record
) -> None:
    word = topic.key.rpartition("/")[2]
    clamped, rejected = robot.counted(f"{word} commands clamped"), robot.counted("rejected")

    def told() -> bool:
        # Not only once: the first may come before the robot has discovered its publisher.
        commander.put(topic.key, commander.payload(message))
        commander.put(topic.key, b"\xc1" * 50)
        return robot.counted(f"{word} commands clamped") > clamped and robot.counted("rejected") > rejected

    eventually(told, PATIENCE, "excess and garbage are told")


def test_a_gripper_command_of_long_ago_is_refused_and_told(robot: Robot, commander: Commander) -> None:
    since = time.monotonic_ns()
    refused = robot.counted("gripper commands refused as older")

    def send(opening: float) -> None:
        # Whoever decided all this at one instant and was hung until now.
        stamp = since + commander.number
        commander.put(COMMAND_GRIPPER.key, commander.payload(GripperCommand(opening, 16.0), stamp=stamp))

    def told() -> bool:
        send(0.0)
        return robot.counted("gripper commands refused as older") > refused

    eventually(told, PATIENCE, "it is refused once it is old")
    refused = robot.counted("gripper commands refused as older")
    opening = robot.gripper.opening
    send(0.05)
    eventually(
        lambda: robot.counted("gripper commands refused as older") > refused, PATIENCE, "so is the next"
    )
    throughout(lambda: robot.gripper.opening <= opening, 0.5, "the fingers stay")


def test_what_the_gripper_is_asked_while_stopped_is_refused_for_good(
    robot: Robot, commander: Commander
) -> None:
    refused = robot.counted("gripper commands refused while stopped")
    opening = robot.gripper.opening
    wanted = 0.05 if opening < 0.025 else 0.0

    def told() -> bool:
        commander.put(COMMAND_GRIPPER.key, commander.payload(GripperCommand(wanted, 16.0)))
        return robot.counted("gripper commands refused while stopped") > refused

    commander.stop(True, "hand on the button")
    try:
        eventually(lambda: robot.status.mode == "stopped", PATIENCE, "the gate is stopped")
        eventually(told, PATIENCE, "it is refused")
    finally:
        # From the same session as the commands, so that none of them overtakes it.
        commander.stop(False)
    eventually(lambda: robot.status.mode != "stopped", PATIENCE, "released")
    throughout(lambda: abs(robot.gripper.opening - opening) < 1e-3, 0.5, "the fingers stay")


@pytest.mark.parametrize("valid", [True, False], ids=["valid", "invalid"])
def test_a_stop_is_latched_whoever_comes_and_goes_and_only_a_valid_release_ends_it(
    robot: Robot, commander: Commander, second: Commander, valid: bool
) -> None:
    commander.make = swaying(2)
    eventually(moves(robot, 2), PATIENCE, "the tool moves")
    second.stop(True, "hand on the button", valid)
    try:
        eventually(lambda: robot.status.mode == "stopped", PATIENCE, "the gate is stopped")
        assert "hand on the button" in robot.status.reason
        robot.rests()
        commander.make = lambda: None
        second.make = swaying(2)
        throughout(robot.at_rest, 0.5, "another controller does not move it either")
        second.stop(False, valid=False)
        throughout(robot.at_rest, 0.3, "nor after an invalid release")
        assert robot.status.mode == "stopped"
    finally:
        second.stop(False)
    eventually(moves(robot, 2), PATIENCE, "it moves after the release")
