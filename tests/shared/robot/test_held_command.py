"""Gripper and head: what is taken over of their commands, and what is told of the rest."""

from __future__ import annotations

import pytest

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.loop.stack import Stack
from shared.messages import GripperCommand, HeadCommand, Stop
from shared.robot.held_command import OLDEST
from shared.schema.records import Record
from shared.service import Inputs
from shared.topics import COMMAND_GRIPPER, COMMAND_HEAD, STATE_ROBOT, STOP, Topic
from tests.shared.rig import Publisher
from tests.shared.robot.rig import Process

OPEN, AWAY = GripperCommand(0.08, 16.0), HeadCommand(0.3, -0.2)


@pytest.fixture
def process() -> Process:
    return Process()


def test_gripper_and_head_do_what_they_can_and_an_excess_is_told(process: Process) -> None:
    process.send(COMMAND_GRIPPER, GripperCommand(5.0, 10.0))
    process.send(COMMAND_HEAD, HeadCommand(0.3, -9.0))
    process.tick()
    gripper, head = process.side.gripper, process.side.head
    assert gripper is not None and (gripper.opening, gripper.effort) == (0.09, 10.0)
    assert head is not None and (head.pan, head.tilt) == (0.3, -1.0)
    process.tick()
    assert process.side.gripper is None and process.side.head is None, "each once"
    process.run(0.3)
    assert "gripper commands clamped: 1" in process.statuses[-1].reason
    assert "head commands clamped: 1" in process.statuses[-1].reason


def test_gripper_and_head_do_not_what_is_marked_invalid(process: Process) -> None:
    process.send(COMMAND_GRIPPER, GripperCommand(0.05, 10.0), valid=False)
    process.send(COMMAND_HEAD, HeadCommand(0.3, 0.0), valid=False)
    process.tick()
    assert process.side.gripper is None and process.side.head is None
    process.run(0.3)
    assert "gripper commands refused as marked invalid: 1" in process.statuses[-1].reason
    assert "head commands refused as marked invalid: 1" in process.statuses[-1].reason


def test_what_the_inputs_refused_of_gripper_and_head_is_named(process: Process) -> None:
    for topic in (COMMAND_GRIPPER, COMMAND_HEAD):
        process.side.take(Inputs({}, {topic.key: "3 from a second session refused"}))
        process.side.report(1.0)
        (output,) = process.side.report(1.0)
        assert f"{topic.key}: 3 from a second session refused" in output.message.reason


@pytest.mark.parametrize(("topic", "message"), [(COMMAND_GRIPPER, OPEN), (COMMAND_HEAD, AWAY)])
def test_what_is_too_old_is_not_carried_out_and_told(process: Process, topic: Topic, message: Record) -> None:
    word = topic.key.rpartition("/")[2]
    for age, taken in ((OLDEST, True), (OLDEST + 0.01, False), (60.0, False)):
        process.send(topic, message, age=age)
        process.tick()
        assert (getattr(process.side, word) is not None) is taken, age
    process.run(0.3)
    assert f"{word} commands refused as older than 1 s: 2" in process.statuses[-1].reason


@pytest.mark.parametrize(("topic", "message"), [(COMMAND_GRIPPER, OPEN), (COMMAND_HEAD, AWAY)])
def test_what_is_asked_while_stopped_is_refused_for_good_and_told(
    process: Process, topic: Topic, message: Record
) -> None:
    word = topic.key.rpartition("/")[2]

    def taken() -> bool:
        process.send(topic, message)
        process.tick()
        return getattr(process.side, word) is not None

    process.send(STOP, Stop(True, "hand on the button"))
    assert not taken(), "together with the stop"
    assert not taken()
    process.send(STOP, Stop(False, ""), valid=False)
    assert not taken(), "an invalid release is none"
    process.send(STOP, Stop(False, ""))
    assert not taken(), "together with the release: it may be older"
    for _ in range(20):
        process.tick()
        assert getattr(process.side, word) is None, "nor afterwards"
    assert f"{word} commands refused while stopped: 4" in process.statuses[-1].reason
    assert taken(), "what is asked after the release"


def test_fingers_and_head_are_told_once_to_stay_when_a_stop_is_engaged(process: Process) -> None:
    told = []
    for engaged in (None, True, None, True, False, None, True):
        if engaged is not None:
            process.send(STOP, Stop(engaged, ""))
        process.tick()
        told.append(process.side.freeze)
    assert told == [False, True, False, False, False, False, True]


def test_what_a_task_decided_before_it_was_hung_does_not_open_the_fingers_when_it_wakes() -> None:
    stack = Stack()
    robot = MockRobot(MockParameters())
    stack.add(robot)
    said: list[str] = []
    stack.client.watch(STATE_ROBOT, lambda received: said.append(received.message.reason))
    task = Publisher(stack.scheduler.clock, epoch=5000.0)  # type: ignore[arg-type]

    def send(opening: float, stamp: int | None = None) -> float:
        payload = task.payload(GripperCommand(opening, 16.0), stamp=stamp)
        stack.bus.publish(COMMAND_GRIPPER.key, payload)
        stack.run(0.3)
        return robot.motors.opening

    assert send(0.0) == 0.0
    decided = task.stamp()
    stack.run(60.0)
    assert send(0.08, decided) == 0.0
    assert "gripper commands refused as older than 1 s: 1" in said[-1]
    assert send(0.08) == 0.08, "what it decides now"
