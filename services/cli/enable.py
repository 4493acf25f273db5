"""`tandem enable`: a key of the keyboard as the hold-to-run device."""

from __future__ import annotations

import os
import select
import sys
import termios
import time
import tty

import typer

from services.cli.common import DEFAULT_ENDPOINT, DEFAULT_ROBOT, Connect, Robot, open_bus, refuse, stop_event
from shared import topics
from shared.messages import EnableDevice, RobotStatus
from shared.wire.client import Client, forbidden, unheard

REPEATS_WITHIN = 0.15
"""[s] Longest time between two characters of a key that is held. A terminal tells of no key that is let go, only of one
that repeats: so the device is pressed from the second character on, and let go when the next one stays out."""


class HeldKey:
    """Whether a key is held, by the characters that arrive while it repeats."""

    def __init__(self) -> None:
        self._last = self._before = -REPEATS_WITHIN

    def typed(self, now: float) -> None:
        """A character has arrived at a time [s] of the steady clock."""
        self._before, self._last = self._last, now

    def held(self, now: float) -> bool:
        """Whether the key is held at a time [s] of the steady clock."""
        return now - self._last < REPEATS_WITHIN and self._last - self._before < REPEATS_WITHIN


def enable(robot: Robot = DEFAULT_ROBOT, connect: Connect = DEFAULT_ENDPOINT) -> None:
    """Let the robot move while a key is held, until Ctrl-C. It starts once the key repeats, and ends with it."""
    if not sys.stdin.isatty():
        refuse("it needs a terminal, whose keys are held; the page of `tandem view` has a button instead")
    with open_bus(robot, connect) as bus:
        if why := forbidden(topics.OPERATOR_ENABLE):
            refuse(why)
        client = Client(bus, name="enable")
        gate = client.watch(topics.STATE_ROBOT)
        typer.echo("hold any key: the robot may move while it repeats (Ctrl-C ends this command)")
        keys, end, shown = HeldKey(), stop_event(), ""
        terminal = sys.stdin.fileno()
        before = termios.tcgetattr(terminal)
        try:
            tty.setcbreak(terminal)
            while not end.is_set():
                # The terminal wakes it for each character; so what is let go is told no later than its next turn.
                if select.select([terminal], [], [], 0.5 / topics.OPERATOR_ENABLE.rate)[0]:
                    os.read(terminal, 1024)
                    keys.typed(time.monotonic())
                pressed = keys.held(time.monotonic())
                client.publish(topics.OPERATOR_ENABLE, EnableDevice(pressed))
                newest = gate.latest.message if gate.latest else None
                if (said := in_words(pressed, newest, unheard(gate))) != shown:
                    shown = said
                    typer.echo(said)
        finally:
            client.publish(topics.OPERATOR_ENABLE, EnableDevice(False))
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)
    typer.echo("let go: the robot does not move")


def in_words(pressed: bool, robot: RobotStatus | None, silent: str) -> str:
    """What the device does at present.

    Args:
        pressed: whether it is pressed.
        robot: the robot's newest word.
        silent: why nothing of it can be used; empty if it can.
    """
    word = "pressed" if pressed else "let go"
    if robot is None or silent:
        return f"{word}, but the robot does not answer: {silent or 'nothing was heard'}"
    if not robot.require_enable:
        return f"{word}, but this robot moves without it: its `require_enable` is off"
    return f"{word}: the robot {'may move' if pressed else 'does not move'}"
