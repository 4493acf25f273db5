"""Notes what is said beside a robot: ``python -m tests.faults.witness ENDPOINT FILE CREDENTIALS``, until SIGTERM.

A line each: steady clock [s], key, session and number of the message, its stamp [s], and the speed in it [m/s], if any.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from shared.clock import seconds
from shared.loop.process import StopRequest
from shared.topics import COMMAND_EE_TWIST, SENSOR_FT, STATE_EE, WRENCH_EXTERNAL, Topic
from shared.wire.codec import decode
from shared.wire.credentials import Credentials
from shared.wire.zenoh import ZenohBus


class Note(NamedTuple):
    """One message as it was heard."""

    time: float
    key: str
    session: int
    number: int
    stamp: float
    speed: float


def notes(file: Path) -> list[Note]:
    """All of a file, but a line that is not whole yet."""
    return [Note(*json.loads(line)) for line in file.read_text().split("\n")[:-1]]


def witness(bus: ZenohBus, write: Callable[[str], object]) -> None:
    """Note every message that arrives from now on, what comes twice as well."""
    lock = threading.Lock()

    def note(topic: Topic[Any], payload: bytes) -> None:
        now = time.monotonic()
        header, message = decode(topic.message, payload, topic.cap)
        linear = getattr(message, "linear", None)
        speed = 0.0 if linear is None else float(np.linalg.norm(linear))
        with lock:
            write(json.dumps(Note(now, topic.key, header.session, header.seq, seconds(header.stamp), speed)) + "\n")

    for topic in (COMMAND_EE_TWIST, SENSOR_FT, STATE_EE, WRENCH_EXTERNAL):
        bus.subscribe(topic.key, partial(note, topic))


def main() -> None:
    """Note until SIGTERM."""
    endpoint, file, folder = sys.argv[1:]
    stop = StopRequest()
    bus = ZenohBus(connect=endpoint, credentials=Credentials.of(folder))
    with Path(file).open("w", buffering=1) as sink, closing(bus):
        witness(bus, sink.write)
        print("witnessing", flush=True)
        while not stop.requested:
            stop.wake.wait(0.2)


if __name__ == "__main__":
    main()
