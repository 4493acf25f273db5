"""A robot that publishes its wrist sensor and its tool at 30 Hz, and misbehaves from SIGUSR1 to SIGUSR2.

Each program of this folder states one kind of misbehaviour and plays it: ``python -m tests.faults.programs.<name>``.
"""

from __future__ import annotations

import argparse
import signal
import time
from collections.abc import Callable, Iterable
from typing import Any

import msgpack

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.clock import SteadyClock, seconds
from shared.loop.runner import Runner
from shared.topics import SENSOR_FT, STATE_EE
from tests.support.spoilt_bus import Spoil, SpoiltBus, healthy

PERIOD = 1 / 30
"""The slowest rate of the contract: what is told late or lost at it is the fault's doing, not a loaded machine's."""
POSITION = (0.5, -0.3, 1.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)


def altered(payload: bytes, **fields: Any) -> bytes:
    """The payload with some of its fields replaced."""
    return msgpack.packb({**msgpack.unpackb(payload), **fields})


def sensor_only(spoil: Callable[[bytes], Iterable[bytes]]) -> Spoil:
    """Spoils the force-torque samples and nothing else."""
    return lambda key, payload: spoil(payload) if key == SENSOR_FT.key else (payload,)


def play(spoil: Spoil = healthy, rate: float = 1 / PERIOD) -> None:
    """Run until SIGTERM, with ``rate`` [Hz] messages of each kind per second."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--connect", required=True)
    switch = {"on": False, "ended": False}
    signal.signal(signal.SIGUSR1, lambda *_: switch.update(on=True))
    signal.signal(signal.SIGUSR2, lambda *_: switch.update(on=False))
    signal.signal(signal.SIGTERM, lambda *_: switch.update(ended=True))
    bus = SpoiltBus(parser.parse_args().connect)

    def misbehave(key: str, payload: bytes) -> Iterable[bytes]:
        if key not in (SENSOR_FT.key, STATE_EE.key):
            return ()
        return spoil(key, payload) if switch["on"] else (payload,)

    bus.spoil = misbehave
    clock = SteadyClock()
    robot = MockRobot(MockParameters(rate=rate, still=True, position=POSITION))
    runner = Runner(robot, bus, clock)
    print("playing", flush=True)
    while not switch["ended"]:
        time.sleep(max(0.0, seconds(runner.next_deadline() - clock.now_ns())))
        runner.poll()
    bus.close()


if __name__ == "__main__":
    play()
