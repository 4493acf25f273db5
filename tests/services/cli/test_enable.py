"""`tandem enable`: the robot moves while a key is held, and stands once it is let go."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from services.cli.enable import REPEATS_WITHIN, HeldKey, in_words
from shared.messages import RobotStatus, TwistCommand
from tests.conftest import Router, StartProcess
from tests.contract.robot import NAME, Commander, Robot
from tests.support.processes import ROOT
from tests.support.wait import eventually

PATIENCE = 30.0  # [s]


def robot_status(require_enable: bool) -> RobotStatus:
    return RobotStatus("holding", "", "omni", False, 0.3, 1.0, (1.0, 1.0, 1.0), 0, require_enable)


def test_a_key_is_held_from_its_second_character_until_the_next_one_stays_out() -> None:
    key = HeldKey()
    assert not key.held(0.0)
    key.typed(10.0)
    assert not key.held(10.0), "it may be a key that was only touched"
    key.typed(10.5)
    assert not key.held(10.5), "the pause before a key repeats"
    for count in range(1, 10):
        key.typed(10.5 + 0.04 * count)
        assert key.held(10.5 + 0.04 * count + 0.03)
    assert not key.held(10.5 + 0.04 * 9 + REPEATS_WITHIN)


def test_it_says_no_more_than_is_known() -> None:
    assert in_words(True, robot_status(True), "") == "pressed: the robot may move"
    assert in_words(False, robot_status(True), "") == "let go: the robot does not move"
    assert "moves without it" in in_words(False, robot_status(False), "")
    assert "does not answer" in in_words(True, None, "") and "old" in in_words(True, robot_status(True), "old")


@contextmanager
def typing(keyboard: int) -> Iterator[None]:
    """A key that is held: its character comes 25 times a second."""
    ended = threading.Event()

    def repeat() -> None:
        while not ended.wait(0.04):
            os.write(keyboard, b" ")

    thread = threading.Thread(target=repeat)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@pytest.mark.processes
def test_the_robot_moves_while_a_key_is_held(start: StartProcess, router: Router) -> None:
    robot, commander = Robot(router.endpoint), Commander(router.endpoint)
    start("services.mock", *robot.options, "--set", "require_enable=true")
    robot.started()
    commander.make = lambda: TwistCommand((0.05, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1)
    command = [sys.executable, "-m", "services.cli", "enable", "--robot", NAME, "--connect", router.endpoint]
    keyboard, terminal = pty.openpty()
    with subprocess.Popen(command, cwd=ROOT, stdin=terminal, stdout=subprocess.PIPE, text=True) as device:
        try:
            eventually(lambda: "enabling device" in robot.status.reason, PATIENCE)
            assert robot.speed == 0.0
            assert device.stdout is not None and "hold any key" in device.stdout.readline()
            with typing(keyboard):
                eventually(lambda: robot.speed > 0.04, PATIENCE, "it moves as commanded")
            eventually(lambda: robot.speed == 0.0, PATIENCE, "it stands")
            with typing(keyboard):
                eventually(lambda: robot.speed > 0.04, PATIENCE, "it goes on by itself")
                device.kill()
                eventually(lambda: robot.speed == 0.0, PATIENCE, "silence means let go")
        finally:
            device.kill()
            os.close(keyboard)
            os.close(terminal)
            commander.close()
            robot.close()


def test_it_needs_a_terminal() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "services.cli", "enable"],
        cwd=ROOT,
        input="",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2 and "needs a terminal" in done.stderr and done.stderr.count("\n") == 1
