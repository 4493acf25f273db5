"""A stranger who publishes under every key of the robot and of the controller, as a second session, as often."""

import argparse
import random
import secrets
import signal
import time

from shared.messages import FtSample, Header, TwistCommand
from shared.topics import COMMAND_EE_TWIST, SENSOR_FT
from shared.wire.codec import encode
from shared.wire.zenoh import ZenohBus
from tests.faults.programs.robot import LEVEL, PERIOD


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--connect", required=True)
    bus = ZenohBus(connect=parser.parse_args().connect)
    session, ended = secrets.randbits(62), []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    print("playing", flush=True)
    sequence = 0
    while not ended:
        header = Header(sequence, session, time.monotonic_ns(), True)
        command = TwistCommand((0.0, 0.2, 0.0), (0.0,) * 3, ttl=0.2)
        sample = FtSample((random.gauss(100.0, 0.05), 0.0, 0.0), (0.0,) * 3, LEVEL, (0.0, 0.0, 0.1), False)
        bus.publish(COMMAND_EE_TWIST.key, encode(command, header))
        bus.publish(SENSOR_FT.key, encode(sample, header))
        sequence += 1
        time.sleep(PERIOD)
    bus.close()


if __name__ == "__main__":
    main()
