"""A robot process as the contract shows it: started somehow, heard and commanded through a router, nothing else."""

from __future__ import annotations

import re
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
import zenoh

from shared.messages import Header, Stop, TwistCommand
from shared.schema.records import Record
from shared.spatial import Array, rotation_matrix
from shared.topics import (
    COMMAND_EE_TWIST,
    SENSOR_CAMERA,
    SENSOR_FT,
    STATE_BASE,
    STATE_EE,
    STATE_GRIPPER,
    STATE_ROBOT,
    STOP,
    TOPICS,
    Topic,
    topic_by_key,
)
from shared.wire.codec import Rejected, decode, encode
from tests.support.ports import open_session
from tests.support.processes import Process
from tests.support.wait import eventually

NAME = "fred"
"""First chunk of the keys: not the default one."""
PATIENCE = 60.0
"""Longest wait [s] for what has to happen; spent only by a test that fails."""
ZERO = (0.0, 0.0, 0.0)
_KEPT = 2000


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


@dataclass(frozen=True)
class Heard:
    """One payload with what it says."""

    encoding: str
    header: Header
    message: Record


class Network:
    """A client of the router that knows nothing of the project's own bus."""

    def __init__(self, endpoint: str) -> None:
        self.session = open_session(endpoint)

    def put(self, key: str, payload: bytes) -> None:
        self.session.put(f"{NAME}/{key}", payload, encoding=zenoh.Encoding("application/msgpack"))

    def close(self) -> None:
        self.session.close()


class Commander(Network):
    """Whoever commands: sends what ``make`` gives on ``topic`` a hundred times a second, a command or a payload."""

    def __init__(self, endpoint: str, topic: Topic = COMMAND_EE_TWIST) -> None:
        super().__init__(endpoint)
        self.topic = topic
        self.make: Callable[[], Record | bytes | None] = lambda: None
        self.number = 0
        self._id = secrets.randbits(62)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.wait(0.01):
            made = self.make()
            if made is not None:
                self.put(self.topic.key, made if isinstance(made, bytes) else self.payload(made))

    def payload(
        self, message: Record, valid: bool = True, number: int | None = None, stamp: int | None = None
    ) -> bytes:
        """A message with the next sequence number and of this instant, or of the past."""
        if number is None:
            self.number += 1
        sequence = self.number if number is None else number
        return encode(message, Header(sequence, self._id, stamp or time.monotonic_ns(), valid))

    def stop(self, engaged: bool, reason: str = "", valid: bool = True) -> None:
        self.put(STOP.key, self.payload(Stop(engaged, reason), valid))

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        super().close()


def _newest(topic: Topic) -> Any:
    """The newest message of a topic, as an attribute of ``Robot``."""
    return property(lambda robot: robot.heard[topic.key][-1].message)


class Robot(Network):
    """What is published under the robot's name, but for the camera's pictures: they are taken for those who ask."""

    def __init__(self, endpoint: str, name: str = NAME) -> None:
        super().__init__(endpoint)
        self._name = name
        self.options = ("--robot", name, "--connect", endpoint)
        self.heard: dict[str, deque[Heard]] = {}
        self.rejected: list[str] = []
        keys = [topic.key for topic in TOPICS if topic is not SENSOR_CAMERA] + ["health/*"]
        self._subscribers = [self.session.declare_subscriber(f"{name}/{key}", self._on_sample) for key in keys]

    @contextmanager
    def listening(self, key: str) -> Iterator[deque[zenoh.Sample]]:
        """What else is published there, while it is listened to."""
        samples: deque[zenoh.Sample] = deque(maxlen=_KEPT)
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
        topic = topic_by_key(key)
        if topic is STOP or key.startswith("command/"):
            return
        try:
            assert topic is not None, "no key of the contract"
            header, message = decode(topic.message, sample.payload.to_bytes(), topic.cap)
        except (AssertionError, Rejected) as problem:
            self.rejected.append(f"{key}: {problem}")
            return
        heard = Heard(str(sample.encoding), header, message)
        self.heard.setdefault(key, deque(maxlen=_KEPT)).append(heard)

    def started(self) -> Robot:
        eventually(
            lambda: {"state/ee", "state/base", "state/robot", "sensor/ft"} <= set(self.heard), PATIENCE, "it speaks"
        )
        return self

    def all(self, topic: Topic) -> list[Heard]:
        return list(self.heard.get(topic.key, ()))

    tool = _newest(STATE_EE)
    sample = _newest(SENSOR_FT)
    status = _newest(STATE_ROBOT)
    base = _newest(STATE_BASE)
    gripper = _newest(STATE_GRIPPER)

    @property
    def rotation(self) -> Array:
        return rotation_matrix(self.tool.orientation)

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.tool.linear))

    def at_rest(self) -> bool:
        return self.speed < 2e-3 and float(np.linalg.norm(self.tool.angular)) < 1e-2

    def rests(self) -> None:
        eventually(self.at_rest, PATIENCE, "the tool stands still")

    def base_at_rest(self) -> bool:
        return bool((np.abs(self.base.velocity) < (2e-3, 2e-3, 4e-3)).all())

    def counted(self, what: str) -> int:
        """How many cases of that kind the robot has named so far."""
        cases = re.findall(rf"{what}[^;,]*?: (\d+)|(\d+) [^;,]*?{what}", self.status.reason)
        return sum(int(number) for case in cases for number in case if number)

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
