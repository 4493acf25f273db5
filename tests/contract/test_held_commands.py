"""Gripper and head of a robot process, from outside: their commands hold until the next one."""

from __future__ import annotations

import time

import pytest

from shared.messages import GripperCommand, HeadCommand
from shared.schema.records import Record
from shared.topics import COMMAND_GRIPPER, COMMAND_HEAD, Topic
from tests.contract.robot import PATIENCE, Commander, Robot
from tests.support.wait import eventually, throughout

pytestmark = pytest.mark.processes


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
    eventually(lambda: robot.counted("gripper commands refused as older") > refused, PATIENCE, "so is the next")
    throughout(lambda: robot.gripper.opening <= opening, 0.5, "the fingers stay")


def test_what_the_gripper_is_asked_while_stopped_is_refused_for_good(robot: Robot, commander: Commander) -> None:
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
