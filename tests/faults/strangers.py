"""Programs that nobody asked for on the robot's bus: ``python -m tests.faults.strangers NAME --connect ENDPOINT``."""

from __future__ import annotations

import argparse
import itertools
import random
import secrets
import signal
import threading
import time

from shared.messages import FtSample, Header, TwistCommand
from shared.topics import (
    COMMAND_EE_TWIST,
    CONTROL_PARAMETERS,
    SENSOR_FT,
    WRENCH_IDENTIFY,
    WRENCH_PARAMETERS,
    WRENCH_TARE,
)
from shared.wire.bus import NoReply
from shared.wire.codec import encode, encode_map
from shared.wire.zenoh import ZenohBus
from tests.faults.programs import LEVEL, PERIOD

KEYS = itertools.cycle((CONTROL_PARAMETERS.key, WRENCH_PARAMETERS.key, WRENCH_IDENTIFY.key, WRENCH_TARE.key))
NESTED = b"\x81\xa3set\x81\xa6period" + b"\x91" * 1015 + b"\x01"
REQUESTS = itertools.cycle(
    (b"", b"\xc1", encode_map({"set": {"period": "now"}}), NESTED, encode_map({"action": 3, "duration": "x"}))
)


def second_publisher(bus: ZenohBus, ended: list[bool]) -> None:
    """Publishes under a key of the robot and one of the controller, as a second session, as often."""
    session = secrets.randbits(62)
    sequence = 0
    while not ended:
        header = Header(sequence, session, time.monotonic_ns(), True)
        command = TwistCommand((0.0, 0.2, 0.0), (0.0,) * 3, ttl=0.2)
        sample = FtSample((random.gauss(100.0, 0.05), 0.0, 0.0), (0.0,) * 3, LEVEL, (0.0, 0.0, 0.1), False)
        bus.publish(COMMAND_EE_TWIST.key, encode(command, header))
        bus.publish(SENSOR_FT.key, encode(sample, header))
        sequence += 1
        time.sleep(PERIOD)


def query_flood(bus: ZenohBus, ended: list[bool]) -> None:
    """Asks for parameters, and nonsense, as fast as the network takes it."""

    def ask() -> None:
        while not ended:
            try:
                bus.query(next(KEYS), next(REQUESTS), timeout=0.2)
            except NoReply:
                continue

    askers = [threading.Thread(target=ask) for _ in range(8)]
    for asker in askers:
        asker.start()
    for asker in askers:
        asker.join()


def main() -> None:
    """Play one of them until SIGTERM."""
    programs = {play.__name__: play for play in (second_publisher, query_flood)}
    parser = argparse.ArgumentParser()
    parser.add_argument("name", choices=programs)
    parser.add_argument("--connect", required=True)
    options = parser.parse_args()
    ended: list[bool] = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    bus = ZenohBus(connect=options.connect)
    print("playing", flush=True)
    programs[options.name](bus, ended)
    bus.close()


if __name__ == "__main__":
    main()
