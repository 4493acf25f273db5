"""A robot that publishes its wrist sensor and its tool at 30 Hz, and misbehaves from SIGUSR1 to SIGUSR2.

Each program of this folder states one kind of misbehaviour and plays it: ``python -m tests.faults.programs.<name>``.
"""

from __future__ import annotations

import argparse
import random
import secrets
import signal
import time
from collections.abc import Callable, Iterable
from typing import Any

import msgpack

from shared.bus_zenoh import ZenohBus
from shared.codec import encode
from shared.messages import EndEffector, FtSample, Header
from shared.topics import SENSOR_FT, STATE_EE

PERIOD = 1 / 30
"""The slowest rate of the contract: what is told late or lost at it is the fault's doing, not a loaded machine's."""
POSITION = (0.5, -0.3, 1.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)

Spoil = Callable[[str, bytes], Iterable[bytes]]
"""What is sent in place of a payload under a key; called once per payload while misbehaving."""


def healthy(_key: str, payload: bytes) -> Iterable[bytes]:
    """The payload as it is."""
    return (payload,)


def altered(payload: bytes, **fields: Any) -> bytes:
    """The payload with some of its fields replaced."""
    return msgpack.packb({**msgpack.unpackb(payload), **fields})


def sensor_only(spoil: Callable[[bytes], Iterable[bytes]]) -> Spoil:
    """Spoils the force-torque samples and nothing else."""
    return lambda key, payload: spoil(payload) if key == SENSOR_FT.key else (payload,)


def play(spoil: Spoil = healthy) -> None:
    """Run until SIGTERM."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--connect", required=True)
    switch = {"on": False, "ended": False}
    signal.signal(signal.SIGUSR1, lambda *_: switch.update(on=True))
    signal.signal(signal.SIGUSR2, lambda *_: switch.update(on=False))
    signal.signal(signal.SIGTERM, lambda *_: switch.update(ended=True))
    bus = ZenohBus(connect=parser.parse_args().connect)
    session, noise = secrets.randbits(62), random.Random(1)
    due, sequence = time.monotonic(), 0
    print("playing", flush=True)
    while not switch["ended"]:
        header = Header(sequence, session, time.monotonic_ns(), True)
        force, torque = ([noise.gauss(0.0, scale) for _ in range(3)] for scale in (0.05, 0.002))
        messages = (
            (STATE_EE.key, EndEffector(POSITION, LEVEL, (0.0,) * 3, (0.0,) * 3)),
            (SENSOR_FT.key, FtSample(force, torque, LEVEL, (0.0, 0.0, 0.1), False)),
        )
        for key, message in messages:
            payload = encode(message, header)
            for sent in spoil(key, payload) if switch["on"] else (payload,):
                bus.publish(key, sent)
        sequence += 1
        due = max(due + PERIOD, time.monotonic() - PERIOD)
        time.sleep(max(0.0, due - time.monotonic()))
    bus.close()


if __name__ == "__main__":
    play()
