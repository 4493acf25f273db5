"""A stranger who asks for parameters, and nonsense, as fast as the network takes it."""

import argparse
import itertools
import signal
import threading

from shared.topics import CONTROL_PARAMETERS, WRENCH_IDENTIFY, WRENCH_PARAMETERS, WRENCH_TARE
from shared.wire.bus import NoReply
from shared.wire.codec import encode_map
from shared.wire.zenoh import ZenohBus

KEYS = itertools.cycle((CONTROL_PARAMETERS.key, WRENCH_PARAMETERS.key, WRENCH_IDENTIFY.key, WRENCH_TARE.key))
NESTED = b"\x81\xa3set\x81\xa6period" + b"\x91" * 1015 + b"\x01"
REQUESTS = itertools.cycle(
    (b"", b"\xc1", encode_map({"set": {"period": "now"}}), NESTED, encode_map({"action": 3, "duration": "x"}))
)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--connect", required=True)
    bus = ZenohBus(connect=parser.parse_args().connect)
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())

    def ask() -> None:
        while not ended.is_set():
            try:
                bus.query(next(KEYS), next(REQUESTS), timeout=0.2)
            except NoReply:
                continue

    askers = [threading.Thread(target=ask) for _ in range(8)]
    for asker in askers:
        asker.start()
    print("playing", flush=True)
    while not ended.wait(0.2):
        pass
    for asker in askers:
        asker.join()
    bus.close()


if __name__ == "__main__":
    main()
