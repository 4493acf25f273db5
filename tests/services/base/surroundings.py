"""Robot, wrench service and task in one, around a base service that runs as a process."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable

import msgpack
import numpy as np

from shared.bus_zenoh import ZenohBus
from shared.client import Client
from shared.clock import SteadyClock
from shared.codec import encode
from shared.inlet import Received
from shared.messages import (
    BaseStatus,
    BaseTwistCommand,
    Enable,
    EndEffector,
    ExternalWrench,
    Header,
    RobotStatus,
)
from shared.records import Record
from shared.topics import (
    BASE_ENABLE,
    BASE_STATUS,
    COMMAND_BASE_TWIST,
    STATE_EE,
    STATE_ROBOT,
    WRENCH_EXTERNAL,
    Topic,
    health_topic,
)

PERIOD = 0.01
ON_TIME = 0.02
"""Time [s] between two turns of the test's own thread beyond which a measurement says nothing about the service."""
Spoil = Callable[[bytes], bytes | None]


def faithfully(payload: bytes) -> bytes:
    return payload


def silently(payload: bytes) -> None:
    return None


def changed(**fields: object) -> Spoil:
    """Replaces fields of a map."""
    return lambda payload: msgpack.packb({**msgpack.unpackb(payload), **fields})


class Surroundings:
    """Robot, wrench service and task in one: publishes from a thread of its own, collects what the base says."""

    def __init__(self, endpoint: str) -> None:
        self.bus = ZenohBus(connect=endpoint)
        self.client = Client(self.bus)
        self.valid, self.fault, self.enabled = True, "", True
        self.spoil: dict[str, Spoil] = {}
        self.commands: list[Received[BaseTwistCommand]] = []
        self.statuses: list[Received[BaseStatus]] = []
        self.client.watch(COMMAND_BASE_TWIST, self.commands.append)
        self.client.watch(BASE_STATUS, self.statuses.append)
        self.health = self.client.watch(health_topic("base"))
        self.last_sound_ns = 0
        self.punctual = True
        self._session = secrets.randbits(60)
        self._sequences: dict[str, int] = {}
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._publish)
        self._thread.start()

    def _publish(self) -> None:
        due, tick, zero = time.monotonic(), 0, np.zeros(3)
        robot = RobotStatus("ready", "", "omni", False, 0.3, 1.0, (1.0, 1.0, 2.0))
        while not self._ended.wait(max(0.0, due - time.monotonic())):
            self.punctual &= time.monotonic() - due < ON_TIME
            due += PERIOD
            self._send(STATE_EE, EndEffector((0.5, 0.0, 1.0), (0, 0, 0, 1), zero, zero))
            wrench = ExternalWrench((6.0, 0.0, -7.0), zero, (0.2,) * 6, "tare", self.fault)
            if self._send(WRENCH_EXTERNAL, wrench, self.valid) and self.valid:
                self.last_sound_ns = SteadyClock().now_ns()
            if tick % 20 == 0:
                self._send(STATE_ROBOT, robot)
                self._send(BASE_ENABLE, Enable(self.enabled))
            tick += 1

    def _send(self, topic: Topic, message: Record, valid: bool = True) -> bool:
        """Whether it was sent as it is."""
        sequence = self._sequences.get(topic.key, 0)
        self._sequences[topic.key] = sequence + 1
        payload = encode(message, Header(sequence, self._session, SteadyClock().now_ns(), valid))
        spoilt = self.spoil.get(topic.key, faithfully)(payload)
        if spoilt is not None:
            self.bus.publish(topic.key, spoilt)
        return spoilt == payload

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self.bus.close()

    @property
    def status(self) -> BaseStatus | None:
        return self.statuses[-1].message if self.statuses else None

    @property
    def detail(self) -> str:
        """What the health says."""
        return self.health.latest.message.detail if self.health.latest else ""

    def moving(self) -> bool:
        """Whether the newest command is fresh, valid and moves with the force."""
        if not self.commands:
            return False
        last = self.commands[-1]
        fresh = SteadyClock().now_ns() - last.arrival_ns < 100_000_000
        return fresh and last.header.valid and last.message.velocity[0] > 0.05

    def resting(self) -> bool:
        """Whether the newest command is zero."""
        return bool(self.commands) and not self.commands[-1].message.velocity.any()

    def braked(self, *parts: str) -> Callable[[], bool]:
        """Whether the base has come to rest, braking for a reason with these parts."""
        return lambda: (
            self.status is not None
            and self.status.state == "braking"
            and self.resting()
            and all(part in self.detail for part in parts)
        )

    def unharmed(self) -> None:
        """Nothing was commanded beyond the limits, and nothing sped up in a jump."""
        velocities = np.array([received.message.velocity for received in self.commands])
        assert np.isfinite(velocities).all() and np.linalg.norm(velocities[:, :2], axis=1).max() <= 0.4 + 1e-9
        assert np.diff(velocities[:, 0]).max() <= 0.7 * 0.1 + 1e-9
