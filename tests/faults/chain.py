"""Wrench and controller as processes over a real router, watched from outside while a robot misbehaves."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from shared.messages import ControlStatus, ControlTarget, Stop, TwistCommand
from shared.parameters import Refused
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_STATUS,
    CONTROL_TARGET,
    STOP,
    WRENCH_TARE,
    health_topic,
)
from shared.wire.bus import NoReply
from shared.wire.client import Client
from shared.wire.subscription import Received
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.faults.programs import LEVEL, POSITION
from tests.support.processes import Process
from tests.support.wait import eventually

MAX_LINEAR, MAX_ANGULAR = 0.25, 0.5
"""Speed limits [m/s, rad/s] that the controller is started with."""
PATIENCE = 40.0
"""Longest wait [s] for what has to happen; spent only by a test that fails."""


@dataclass(frozen=True)
class Observed:
    """One command as it arrived."""

    arrival_ns: int
    speed: float
    valid: bool
    session: int

    @property
    def moves(self) -> bool:
        return self.valid and self.speed > 0.0


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
        self.commands.append(Observed(received.arrival_ns, linear + angular, header.valid, header.session))

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


class Chain:
    """The two services, and a task that asks the tool to move on."""

    def __init__(self, router: Router, start: StartProcess, state: Path) -> None:
        self.router = router
        self._start = start
        self._state = state
        self.bus = ZenohBus(connect=router.endpoint)
        self.client = Client(self.bus)
        self.watch = Watch(self.client)
        self.health = {name: self.client.watch(health_topic(name)) for name in ("wrench", "controller")}
        self._ended = threading.Event()
        self._paused = False
        self._task = threading.Thread(target=self._publish_target)
        self._task.start()
        self.wrench = self.start_wrench()
        self.controller = self.start_controller()

    def start_wrench(self) -> Process:
        # A loaded machine delays by more than a robot's: the tests of delay exceed this by far.
        slack = ("--set", "max_delay=0.1")
        environment = {"XDG_STATE_HOME": str(self._state)}
        return self.program("services.wrench", *slack, environment=environment)

    def start_controller(self) -> Process:
        return self.program("services.controller", "--set", "delay=0.1", "--set", "period=0.05")

    def replace_router(self) -> None:
        """Another router in the place of one that was killed."""
        self._start("services.router", "--listen", self.router.endpoint).wait_for_output("listening")

    def program(self, module: str, *options: str, environment: dict[str, str] | None = None) -> Process:
        return self._start(module, "--connect", self.router.endpoint, *options, environment=environment)

    @contextmanager
    def playing(self, name: str = "healthy") -> Iterator[Process]:
        """A robot that works, and misbehaves from SIGUSR1 to SIGUSR2; nothing is harmed by it."""
        with running(self.program("tests.faults.programs", name)) as program:
            self.works("the healthy robot moves")
            yield program
        self.unharmed()

    def _publish_target(self) -> None:
        ahead = (POSITION[0] + 0.3, *POSITION[1:])
        target = ControlTarget(ahead, LEVEL, (25.0,) * 3, (10.0,) * 3)
        while not self._ended.wait(0.1):
            if not self._paused:
                self.client.publish(CONTROL_TARGET, target)

    def pause_target(self, paused: bool = True) -> None:
        """Let the task fall silent, or speak again."""
        self._paused = paused

    def tare(self) -> None:
        """Tare: else the error bound of the uncompensated sensor leaves no room within the limits."""
        with running(self.program("tests.faults.programs", "healthy")):
            eventually(self._tared, PATIENCE, "the sensor is tared")

    def _tared(self) -> bool:
        try:
            return self.client.ask(WRENCH_TARE, {"duration": 0.3})["ok"] is True
        except (NoReply, Refused):
            return False

    def release(self) -> None:
        """What ``tandem resume`` does."""
        self.client.publish(STOP, Stop(False, "test"))

    def works(self, what: str = "the tool is commanded to move") -> None:
        """Wait until the tool moves, and keeps moving for a while."""
        count = len(self.watch.commands)
        eventually(
            lambda: self.watch.moved_since(count) >= 15, PATIENCE, lambda: f"{what} ({self.watch.reason})"
        )

    def brakes(self, what: str = "the controller brakes") -> None:
        eventually(self.watch.stopped, PATIENCE, lambda: f"{what} ({self.watch.reason})")

    def refused(self, service: str, key: str) -> int:
        """How many messages of a key a service refused so far, by its own account."""
        latest = self.health[service].latest
        return latest.message.inputs[key].rejected if latest else 0

    def sensor_ok(self) -> bool:
        """Whether the wrench service reports that all is well."""
        latest = self.health["wrench"].latest
        return latest is not None and latest.message.state == "ok"

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

    def close(self) -> None:
        self._ended.set()
        self._task.join()
        self.bus.close()


@contextmanager
def running(process: Process) -> Iterator[Process]:
    """A program for part of a test."""
    try:
        yield process
    finally:
        process.stop()


@contextmanager
def tared(router: Router, start: StartProcess, state: Path) -> Iterator[Chain]:
    """A chain that works as soon as there is a robot."""
    chain = Chain(router, start, state)
    try:
        chain.tare()
        yield chain
    finally:
        chain.close()
