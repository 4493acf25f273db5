"""Where an enabling device is required nothing moves but while it is pressed."""

from __future__ import annotations

import numpy as np
import pytest

from shared.messages import BaseTwistCommand, EnableDevice, GripperCommand, HeadCommand
from shared.robot.side import NOT_ENABLED
from shared.topics import COMMAND_BASE_TWIST, COMMAND_GRIPPER, COMMAND_HEAD, OPERATOR_ENABLE
from tests.shared.robot.rig import DT, Process


@pytest.fixture
def robot() -> Process:
    return Process(require_enable=True)


def press(robot: Process, pressed: bool = True, valid: bool = True) -> None:
    robot.send(OPERATOR_ENABLE, EnableDevice(pressed), valid)


def moves(robot: Process) -> bool:
    """Whether the tool moves as it is commanded now."""
    robot.move()
    return bool(robot.tick().any())


def test_nothing_moves_before_it_is_pressed_and_the_reason_says_so(robot: Process) -> None:
    assert not any(moves(robot) for _ in range(30))
    robot.run(0.2)
    assert robot.statuses[-1].mode == "holding" and robot.statuses[-1].require_enable
    assert robot.statuses[-1].reason.startswith(NOT_ENABLED)


def test_letting_go_brakes_in_the_same_step_and_pressing_resumes(robot: Process) -> None:
    press(robot)
    assert moves(robot)
    press(robot, False)
    assert not moves(robot)
    press(robot)
    assert moves(robot)


def test_silence_lets_go(robot: Process) -> None:
    press(robot)
    steps = 0
    while moves(robot):
        steps += 1
        assert steps * DT <= OPERATOR_ENABLE.max_age + DT
    assert steps * DT >= OPERATOR_ENABLE.max_age - DT


def test_a_word_that_is_not_to_be_trusted_lets_go(robot: Process) -> None:
    press(robot)
    assert moves(robot)
    press(robot, valid=False)
    assert not moves(robot)


def test_the_base_brakes_and_gripper_and_head_stay(robot: Process) -> None:
    press(robot)
    robot.tick()
    press(robot, False)
    robot.send(COMMAND_GRIPPER, GripperCommand(0.05, 5.0))
    robot.send(COMMAND_HEAD, HeadCommand(0.1, 0.1))
    robot.send(COMMAND_BASE_TWIST, BaseTwistCommand((0.2, 0.0, 0.0), 0.1))
    robot.tick()
    assert robot.side.freeze and robot.side.gripper is None and robot.side.head is None
    assert not robot.side.advance_base(DT).any()
    # What was asked for meanwhile is not done when it is pressed again.
    press(robot)
    robot.tick()
    assert robot.side.gripper is None and robot.side.head is None and not robot.side.freeze


def test_it_releases_no_stop(robot: Process) -> None:
    press(robot)
    robot.side.gate.stop(True, "a child runs in")
    assert not moves(robot) and robot.side.mode == "stopped"


def test_a_robot_that_does_not_require_it_moves_without() -> None:
    robot = Process()
    press(robot, False)
    robot.move()
    assert np.linalg.norm(robot.tick()) > 0.0
