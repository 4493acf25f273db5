"""Robots that misbehave, a function each: ``python -m tests.faults.programs NAME --connect ENDPOINT``.

The mock robot publishes its wrist sensor and its tool at 30 Hz; from SIGUSR1 to SIGUSR2 what the function gives is sent
in place of each payload.
"""

from __future__ import annotations

import argparse
import itertools
import math
import random
import signal
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import msgpack

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.messages import ControlTarget
from shared.parameters import Refused
from shared.topics import SENSOR_FT, STATE_EE, WRENCH_TARE, Topic
from shared.wire.bus import NoReply
from shared.wire.client import Client
from tests.support.spoilt_bus import Spoil, SpoiltBus, live

PERIOD = 1 / 30
"""The slowest rate of the contract: what is told late or lost at it is the fault's doing, not a loaded machine's."""
POSITION = (0.5, -0.3, 1.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)
AHEAD = ControlTarget((POSITION[0] + 0.3, *POSITION[1:]), LEVEL, (25.0,) * 3, (10.0,) * 3)
"""What the tool is asked for while a robot plays."""
HOUR = 3_600 * 10**9  # [ns]
DEEP = b"\x91" * 1020 + b"\xc0"
"""A thousand lists, each in the one before."""
WRONG = itertools.cycle((None, True, "text", b"bytes", [], [1.0], [[0.0] * 3] * 3, {"x": 1.0}, 2**64 - 1, -1))

turn = itertools.count()
past: defaultdict[str, deque[bytes]] = defaultdict(deque)
"""By key, payloads that a function has kept."""


@dataclass(frozen=True)
class Program:
    """How a robot misbehaves.

    Attributes:
        spoil: what is sent in place of a payload.
        rate: of the robot's messages of each kind [Hz].
    """

    spoil: Spoil
    rate: float = 1 / PERIOD


PROGRAMS: dict[str, Program] = {}


def only(topic: Topic, spoil: Spoil) -> Spoil:
    """Spoils what is said on one topic."""
    return lambda key, payload: spoil(key, payload) if key == topic.key else (payload,)


def program(topic: Topic | None = None, rate: float = 1 / PERIOD) -> Callable[[Spoil], Spoil]:
    """A row of ``PROGRAMS`` from a function, which sees the payloads of one topic or of all."""

    def row(spoil: Spoil) -> Spoil:
        PROGRAMS[spoil.__name__] = Program(only(topic, spoil) if topic else spoil, rate)
        return spoil

    return row


def altered(payload: bytes, **fields: Any) -> bytes:
    """The payload with some of its fields replaced."""
    return msgpack.packb({**msgpack.unpackb(payload), **fields})


@program()
def healthy(key: str, payload: bytes) -> Iterable[bytes]:
    """Nothing is wrong."""
    return (payload,)


@program()
def silent_robot(key: str, payload: bytes) -> Iterable[bytes]:
    """Everything that the robot publishes stops."""
    return ()


@program(SENSOR_FT)
def silent_sensor(key: str, payload: bytes) -> Iterable[bytes]:
    """The force-torque samples stop; everything else of the robot goes on."""
    return ()


@program(STATE_EE)
def silent_tool(key: str, payload: bytes) -> Iterable[bytes]:
    """The tool's pose stops; the sensor goes on."""
    return ()


@program(SENSOR_FT)
def nan_sensor(key: str, payload: bytes) -> Iterable[bytes]:
    """A component of the measured force is not a number."""
    return (altered(payload, force=[0.0, math.nan, 0.0]),)


@program(STATE_EE)
def infinite_tool(key: str, payload: bytes) -> Iterable[bytes]:
    """A component of the tool's position is infinite."""
    return (altered(payload, position=[math.inf, 0.0, 0.0]),)


@program(SENSOR_FT)
def invalid_sensor(key: str, payload: bytes) -> Iterable[bytes]:
    """The robot itself says that its samples are not to be trusted."""
    return (altered(payload, valid=False),)


@program(SENSOR_FT)
def saturated_sensor(key: str, payload: bytes) -> Iterable[bytes]:
    """The robot declares that an axis of its sensor is at the end of its range."""
    return (altered(payload, saturated=True, force=[400.0, 0.0, 0.0]),)


@program(SENSOR_FT)
def stuck_sensor(key: str, payload: bytes) -> Iterable[bytes]:
    """One axis of the sensor repeats a value for ever; the others live."""
    force = msgpack.unpackb(payload)["force"]
    return (altered(payload, force=[force[0], 1.25, force[2]]),)


@program()
def garbage(key: str, payload: bytes) -> Iterable[bytes]:
    """Random bytes under every key of the robot."""
    return (random.randbytes(random.randrange(200)),)


@program()
def garbage_between(key: str, payload: bytes) -> Iterable[bytes]:
    """Every sound message comes with a broken one, a megabyte and an empty one around it."""
    return (b"", payload[:-2], payload, bytes(100_000), b"\xc1")


@program()
def wrong_fields(key: str, payload: bytes) -> Iterable[bytes]:
    """Each field in turn missing, of a wrong type, of a wrong shape or nested a thousand lists deep."""
    fields = msgpack.unpackb(payload)
    name = sorted(fields)[next(turn) % len(fields)]
    wrong = altered(payload, **{name: next(WRONG)})
    del fields[name]
    missing = msgpack.packb(fields)
    nested = bytes([0x80 + len(fields) + 1]) + missing[1:] + msgpack.packb(name) + DEEP
    return (missing, nested, wrong)


@program()
def oversized(key: str, payload: bytes) -> Iterable[bytes]:
    """A megabyte in place of every message."""
    return (altered(payload, padding=bytes(1_000_000)),)


@program()
def burst(key: str, payload: bytes) -> Iterable[bytes]:
    """Nothing for half a second, then everything that was held back at once, and so on."""
    past[key].append(payload)
    if len(past[key]) < 15:
        return ()
    sent = tuple(past[key])
    past[key].clear()
    return sent


@program()
def late(key: str, payload: bytes) -> Iterable[bytes]:
    """Every message comes a third of a second after it was made: a slow network, unnoticed but for the stamps."""
    past[key].append(payload)
    return (past[key].popleft(),) if len(past[key]) > 10 else ()


@program()
def duplicates(key: str, payload: bytes) -> Iterable[bytes]:
    """Every message comes three times, and the last ten before it once more, in reverse."""
    again = tuple(past[key])[:-11:-1]
    past[key].append(payload)
    return (payload, payload, *again, payload)


@program(rate=100.0)
def lossy(key: str, payload: bytes) -> Iterable[bytes]:
    """A fifth of the messages is lost, at random, at the default rate."""
    return () if random.random() < 0.2 else (payload,)


@program(rate=100.0)
def very_lossy(key: str, payload: bytes) -> Iterable[bytes]:
    """Three fifths of the messages are lost, at random, at the default rate."""
    return () if random.random() < 0.6 else (payload,)


@program()
def liar_stamp(key: str, payload: bytes) -> Iterable[bytes]:
    """Stamps that jump an hour ahead now and then, under the true session."""
    if next(turn) % 21:
        return (payload,)
    return (altered(payload, stamp=msgpack.unpackb(payload)["stamp"] + HOUR),)


@program()
def jumping_sequence(key: str, payload: bytes) -> Iterable[bytes]:
    """One message of a sequence number far ahead, then the true ones go on: everything after it looks old."""
    if past[key]:
        return (payload,)
    past[key].append(payload)
    return (altered(payload, seq=2**62),)


@program()
def flood(key: str, payload: bytes) -> Iterable[bytes]:
    """Three hundred messages in place of one: 9 kHz on every topic of the robot, each of them new."""
    stamp = msgpack.unpackb(payload)["stamp"]
    return tuple(altered(payload, seq=10**9 + next(turn), stamp=stamp + step * 100_000) for step in range(300))


def tared(client: Client) -> bool:
    """Whether the sensor could be tared: else the error bound that it has without leaves no room within the limits."""
    try:
        return client.ask(WRENCH_TARE, {"duration": 0.5})["ok"] is True
    except (NoReply, Refused):
        return False


def main() -> None:
    """Play a program until SIGTERM."""
    parser = argparse.ArgumentParser()
    parser.add_argument("name", choices=PROGRAMS)
    parser.add_argument("--connect", required=True)
    options = parser.parse_args()
    played = PROGRAMS[options.name]
    switch = {"on": False, "ended": False}
    signal.signal(signal.SIGUSR1, lambda *_: switch.update(on=True))
    signal.signal(signal.SIGUSR2, lambda *_: switch.update(on=False))
    signal.signal(signal.SIGTERM, lambda *_: switch.update(ended=True))

    def said(key: str, payload: bytes) -> Iterable[bytes]:
        if key not in (SENSOR_FT.key, STATE_EE.key):
            return ()
        return played.spoil(key, payload) if switch["on"] else (payload,)

    bus = SpoiltBus(options.connect, said)
    robot = MockRobot(MockParameters(rate=played.rate, still=True, position=POSITION))
    print("playing", flush=True)
    live(robot, bus, lambda: switch["ended"])
    bus.close()


if __name__ == "__main__":
    main()
