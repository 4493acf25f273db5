"""Late steps of services by their own count, in a container of theirs: ``python late_steps.py HEALTHS NAME ...``.

One process hears them all: one for each would be measured along, as a program that starts and ends beside them.
"""

from __future__ import annotations

import json
import os
import sys
import time
from contextlib import closing

from shared.messages import Health
from shared.topics import HEALTH_RATE, health_topic
from shared.wire.client import Client
from shared.wire.credentials import Credentials
from shared.wire.zenoh import ZenohBus


def main(count: int, names: list[str]) -> None:
    """Listen to so many healths of each, and print as JSON the share [%] of late steps by name."""
    heard: dict[str, list[Health]] = {name: [] for name in names}
    with closing(ZenohBus(connect=os.environ["TANDEM_CONNECT"], credentials=Credentials.given())) as bus:
        client = Client(bus)
        for name, healths in heard.items():
            client.watch(health_topic(name), lambda received, healths=healths: healths.append(received.message))
        while any(len(healths) < count for healths in heard.values()):
            time.sleep(0.5)
    print(json.dumps({name: _share(healths[:count]) for name, healths in heard.items()}))


def _share(healths: list[Health]) -> float:
    steps = sum(health.loop_hz for health in healths[1:]) / HEALTH_RATE
    return 100.0 * (healths[-1].overruns - healths[0].overruns) / steps


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
