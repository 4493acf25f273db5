"""A robot process as the contract shows it: started somehow, heard and commanded through a router, nothing else."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import msgpack
import zenoh

from services.cli.check import heard
from shared.messages import TwistCommand
from shared.topics import COMMAND_EE_TWIST, SENSOR_CAMERA, STOP, TOPICS, Topic
from tests.support.ports import open_session
from tests.support.processes import Process
from tests.support.wait import eventually

NAME = "fred"
"""First chunk of the keys: not the default one."""
PATIENCE = 60.0
"""Longest wait [s] for what has to happen; spent only by a test that fails."""
ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RobotProcess:
    """How a robot process is started.

    Attributes:
        module: for ``python -m``.
        with_a_kilogram: options with which it starts with 1 kg hanging from its tool; None if ``sim/command`` hangs it.
        camera: whether it has one.
        world: whether it tells of a world around it, as a simulation does.
    """

    module: str
    with_a_kilogram: tuple[str, ...] | None = None
    camera: bool = True
    world: bool = True


class Network:
    """A client of the router that knows nothing of the project's own bus."""

    def __init__(self, endpoint: str) -> None:
        self.session = open_session(endpoint)

    def put(self, key: str, payload: bytes) -> None:
        self.session.put(f"{NAME}/{key}", payload, encoding=zenoh.Encoding("application/msgpack"))

    def close(self) -> None:
        self.session.close()


class Commander(Network, heard.Commander):
    """Whoever commands: sends what ``make`` gives on ``topic`` a hundred times a second, a command or a payload."""

    def __init__(self, endpoint: str, topic: Topic = COMMAND_EE_TWIST) -> None:
        Network.__init__(self, endpoint)
        heard.Commander.__init__(self, self.put, topic)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.wait(0.01):
            self.send()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        super().close()


class Robot(Network, heard.Robot):
    """What is published under the robot's name, but for the camera's pictures: they are taken for those who ask."""

    def __init__(self, endpoint: str, name: str = NAME) -> None:
        Network.__init__(self, endpoint)
        heard.Robot.__init__(self)
        self._name = name
        self.options = ("--robot", name, "--connect", endpoint)
        keys = [topic.key for topic in TOPICS if topic is not SENSOR_CAMERA] + ["health/*", "setup/*"]
        self._subscribers = [self.session.declare_subscriber(f"{name}/{key}", self._on_sample) for key in keys]

    @contextmanager
    def listening(self, key: str) -> Iterator[deque[zenoh.Sample]]:
        """What else is published there, while it is listened to."""
        samples: deque[zenoh.Sample] = deque(maxlen=heard.KEPT)
        subscriber = self.session.declare_subscriber(f"{self._name}/{key}", samples.append)
        yield samples
        subscriber.undeclare()

    def key(self, sample: zenoh.Sample) -> str:
        """The contract's key of a sample."""
        return str(sample.key_expr).removeprefix(f"{self._name}/")

    def ask(self, key: str, **request: Any) -> dict[str, Any]:
        """The one answer to a query."""
        replies = self.session.get(f"{self._name}/{key}", payload=msgpack.packb(request), timeout=10.0)
        (answer,) = (msgpack.unpackb(reply.ok.payload.to_bytes()) for reply in replies)
        return answer

    def _on_sample(self, sample: zenoh.Sample) -> None:
        key = self.key(sample)
        if key != STOP.key and not key.startswith("command/"):
            self.take(key, sample.payload.to_bytes(), str(sample.encoding))

    def started(self) -> Robot:
        eventually(
            lambda: {"state/ee", "state/base", "state/robot", "sensor/ft"} <= set(self.heard), PATIENCE, "it speaks"
        )
        return self

    def rests(self) -> None:
        eventually(self.at_rest, PATIENCE, "the tool stands still")

    def follow(self, commander: Commander, linear: tuple, angular: tuple, moved: Callable[[], bool]) -> None:
        """Let the robot be commanded until it has moved so far, and come to rest."""
        commander.make = lambda: TwistCommand(linear, angular, 0.1)
        eventually(moved, PATIENCE, f"the tool moves by {linear} and {angular}")
        commander.make = lambda: None
        self.rests()


@contextmanager
def lives_through(robot: Robot, process: Process) -> Iterator[Robot]:
    """The robot of a process once it speaks; the process has to live through all that is done with it."""
    yield robot.started()
    robot.close()
    assert process.running, process.output
    assert "Traceback" not in process.output, process.output
