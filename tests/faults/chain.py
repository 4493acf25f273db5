"""Wrench and controller as processes over a real router, watched from outside while a robot misbehaves."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from shared.messages import ControlStatus, Stop, TwistCommand
from shared.schema.records import Record
from shared.topics import COMMAND_EE_TWIST, CONTROL_STATUS, CONTROL_TARGET, STOP, Topic
from shared.wire.client import Client
from shared.wire.subscription import Received
from tests.conftest import Router, StartProcess
from tests.faults import programs
from tests.support.processes import Process
from tests.support.stand_in import StandIn
from tests.support.wait import eventually

MAX_LINEAR, MAX_ANGULAR = 0.25, 0.5
"""Speed limits [m/s, rad/s] that the controller is started with."""
OPTIONS = {
    # A loaded machine delays by more than a robot's: the tests of delay exceed this by far.
    "wrench": ("--set", "max_delay=0.1"),
    "controller": ("--set", "delay=0.1", "--set", "period=0.05"),
}
"""With which the services are started."""
PATIENCE = 40.0
"""Longest wait [s] for what has to happen; spent only by a test that fails."""


class Observed(NamedTuple):
    """One command: whether it moves the tool, and who sent it."""

    moves: bool
    session: int


class Watch:
    """Everything that the controller commands, held against the limits as it comes in."""

    def __init__(self, client: Client) -> None:
        self.commands: list[Observed] = []
        self.excesses: list[TwistCommand] = []
        self.status: ControlStatus | None = None
        # One thread per subscription: nothing here is written by two.
        self.subscription = client.watch(COMMAND_EE_TWIST, self._command)
        client.watch(CONTROL_STATUS, self._status)

    def _command(self, received: Received[TwistCommand]) -> None:
        message = received.message
        linear, angular = math.hypot(*message.linear.tolist()), math.hypot(*message.angular.tolist())
        if linear > MAX_LINEAR + 1e-9 or angular > MAX_ANGULAR + 1e-9 or message.ttl > 0.2:
            self.excesses.append(message)
        header = received.header
        self.commands.append(Observed(header.valid and linear + angular > 0.0, header.session))

    def _status(self, received: Received[ControlStatus]) -> None:
        self.status = received.message

    def moved_since(self, count: int) -> int:
        """Number of moving commands after the first ``count`` commands."""
        return sum(command.moves for command in self.commands[count:])

    def stopped(self, commands: int = 5) -> bool:
        """Whether the last few commands all brake."""
        last = self.commands[-commands:]
        return len(last) == commands and not any(command.moves for command in last)

    @property
    def reason(self) -> str:
        """What the controller says about it."""
        return self.status.reason if self.status else ""


class Chain(StandIn):
    """The two services, and a task that asks the tool to move on; its ``health`` is that of the wrench service."""

    def __init__(self, router: Router, start: StartProcess, state: Path) -> None:
        super().__init__(router.endpoint, "wrench", self._target, period=0.1)
        self.router = router
        self._start = start
        self._state = state
        self.watch = Watch(self.client)
        self.paused = False
        self.wrench = self.start("wrench")
        self.controller = self.start("controller")

    def start(self, name: str) -> Process:
        """One of the two services."""
        environment = {"XDG_STATE_HOME": str(self._state)}
        return self.program(f"services.{name}", *OPTIONS[name], environment=environment)

    def lose(self, name: str, number: signal.Signals) -> None:
        """Send a signal to a service or the router that ends it or lets it hang."""
        self._process(name).signal(number)
        if number == signal.SIGKILL:
            self._process(name).wait()

    def bring_back(self, name: str, number: signal.Signals) -> None:
        """Start another one in the place of one that was killed, or wake it."""
        if number == signal.SIGSTOP:
            self._process(name).signal(signal.SIGCONT)
        elif name == "router":
            self._start("services.router", "--listen", self.router.endpoint).wait_for_output("listening")
        else:
            setattr(self, name, self.start(name))

    def _process(self, name: str) -> Process:
        return {"router": self.router.process, "wrench": self.wrench, "controller": self.controller}[name]

    def program(self, module: str, *options: str, environment: dict[str, str] | None = None) -> Process:
        return self._start(module, "--connect", self.router.endpoint, *options, environment=environment)

    @contextmanager
    def misbehaving(self, name: str) -> Iterator[Process]:
        """A robot that worked, and misbehaves from now on until SIGUSR2."""
        with self.playing(name) as program:
            program.signal(signal.SIGUSR1)
            yield program

    @contextmanager
    def playing(self, name: str = "healthy") -> Iterator[Process]:
        """A robot that works, and misbehaves from SIGUSR1 to SIGUSR2; nothing is harmed by it."""
        with running(self.program("tests.faults.programs", name)) as program:
            # A zero belongs to one run of the robot process.
            eventually(lambda: programs.tared(self.client), PATIENCE, "the sensor is tared")
            # No test pays for a latch of the one before it.
            self.release()
            self.works("the healthy robot moves")
            yield program
        self.unharmed()

    def _target(self, number: int) -> list[tuple[Topic, Record]]:
        """The target again, unless the task is paused."""
        return [] if self.paused else [(CONTROL_TARGET, programs.AHEAD)]

    def release(self) -> None:
        """What ``tandem resume`` does."""
        self.client.publish(STOP, Stop(False, "test"))

    def works(self, what: str = "the tool is commanded to move") -> None:
        """Wait until the tool moves, and keeps moving for a while."""
        count = len(self.watch.commands)
        eventually(lambda: self.watch.moved_since(count) >= 15, PATIENCE, lambda: f"{what} ({self.watch.reason})")

    def brakes(self, what: str = "the controller brakes") -> None:
        eventually(self.watch.stopped, PATIENCE, lambda: f"{what} ({self.watch.reason})")

    def unharmed(self) -> None:
        """Nothing crashed, nothing was commanded beyond a limit, nothing that is no message was said."""
        for process in (self.wrench, self.controller):
            assert process.running, process.output
            assert "Traceback" not in process.output, process.output
        assert not self.watch.excesses
        assert self.watch.subscription.rejected == 0, self.watch.subscription.last_rejection

    def unharmed_so_far(self) -> bool:
        """``unharmed``, to be asked again and again."""
        self.unharmed()
        return True


@contextmanager
def running(process: Process) -> Iterator[Process]:
    """A program for part of a test."""
    try:
        yield process
    finally:
        process.stop()
