"""A robot whose gate tells when it stops: it publishes its sensors at 100 Hz and runs the real gate at 500 Hz."""

from __future__ import annotations

import random
import secrets
import threading
import time
from collections.abc import Callable, Iterable

from shared.bus_zenoh import ZenohBus
from shared.clock import SteadyClock, seconds
from shared.codec import encode
from shared.inlet import Inlet
from shared.limits import Gate, GateLimits
from shared.messages import EndEffector, FtSample, Header, Stop, TwistCommand
from shared.topics import COMMAND_EE_TWIST, SENSOR_FT, STATE_EE, STOP

TICK = 0.002
TICKS_PER_SAMPLE = 5
POSITION = (0.5, -0.3, 1.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)

Spoil = Callable[[str, bytes], Iterable[bytes]]


def healthy(_key: str, payload: bytes) -> Iterable[bytes]:
    """The payload as it is."""
    return (payload,)


class FaultRobot:
    """Stands still in front of a target that it is asked to move to, and notes what its gate lets through.

    Attributes:
        spoil: what is sent in place of each payload.
        last_sent_ns: when the last sound force-torque sample left.
        moving: whether the gate lets a motion through at present.
        stopped_ns: when it last ceased to.
        moving_ns: since when it moves without a break.
        longest_gap: longest time [s] between two looks of its gate, since set to zero; nominally 2 ms.
    """

    def __init__(self, endpoint: str) -> None:
        self.bus = ZenohBus(connect=endpoint)
        self.spoil: Spoil = healthy
        self.last_sent_ns = self.stopped_ns = self.moving_ns = 0
        self.moving = False
        self.longest_gap = 0.0
        self._clock = SteadyClock()
        self._gate = Gate(GateLimits(0.3, 1.0, 5.0, 10.0))
        self._command: Inlet[TwistCommand] = Inlet(COMMAND_EE_TWIST, self._clock)
        self._stop: Inlet[Stop] = Inlet(STOP, self._clock)
        self._taken = self._stops_taken = 0
        for inlet in (self._command, self._stop):
            self.bus.subscribe(inlet.topic.key, inlet.offer)
        self._session, self._sequence, self._noise = secrets.randbits(62), 0, random.Random(1)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        due, before, tick = time.monotonic(), self._clock.now_ns(), 0
        while not self._ended.is_set():
            now = self._clock.now_ns()
            self.longest_gap = max(self.longest_gap, seconds(now - before))
            self._execute(now, seconds(now - before))
            before = now
            if tick % TICKS_PER_SAMPLE == 0:
                self._publish()
            tick += 1
            due = max(due + TICK, time.monotonic() - TICK)
            time.sleep(max(0.0, due - time.monotonic()))

    def _execute(self, now: int, dt: float) -> None:
        stop = self._stop.latest
        if stop is not None and stop.number != self._stops_taken:
            self._stops_taken = stop.number
            self._gate.stop(stop.message.engaged, stop.message.reason)
        command = self._command.latest
        if command is not None and command.number != self._taken:
            self._taken = command.number
            message = command.message
            age = self._command.age(now)
            self._gate.command(message.linear, message.angular, message.ttl, age, command.header.valid)
        moving = bool(self._gate.advance(dt).any())
        if moving and not self.moving:
            self.moving_ns = now
        if self.moving and not moving:
            self.stopped_ns = self._clock.now_ns()
        self.moving = moving

    def _publish(self) -> None:
        header = Header(self._sequence, self._session, self._clock.now_ns(), True)
        self._sequence += 1
        force, torque = ([self._noise.gauss(0.0, scale) for _ in range(3)] for scale in (0.05, 0.002))
        sample = FtSample(force, torque, LEVEL, (0.0, 0.0, 0.1), False)
        for key, message in (
            (STATE_EE.key, EndEffector(POSITION, LEVEL, (0.0,) * 3, (0.0,) * 3)),
            (SENSOR_FT.key, sample),
        ):
            payload = encode(message, header)
            spoilt = tuple(self.spoil(key, payload))
            for sent in spoilt:
                self.bus.publish(key, sent)
            if key == SENSOR_FT.key and payload in spoilt:
                self.last_sent_ns = self._clock.now_ns()

    def moves_for(self, duration: float) -> bool:
        """Whether it has been moving without a break for so long [s]."""
        return self.moving and self._clock.now_ns() - self.moving_ns > duration * 1e9

    def close(self) -> None:
        """End the robot."""
        self._ended.set()
        self._thread.join()
        self.bus.close()
