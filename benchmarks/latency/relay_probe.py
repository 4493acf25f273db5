"""Source and sink of the bare relay: ``python -m benchmarks.latency.relay_probe <endpoint> <rate> <seconds>``."""

from __future__ import annotations

import sys
import time

from benchmarks.latency.pacing import paced, printed
from shared.wire.zenoh import ZenohBus

ROBOT = "floor"
WARM_UP = 1.0
FT_BYTES, WRENCH_BYTES, TWIST_BYTES, EE_BYTES = 214, 209, 129, 202
"""Sizes [bytes] of sensor/ft, wrench/external, command/ee_twist and state/ee on the wire."""


def main() -> None:
    """Print the latencies [us] as JSON."""
    endpoint, rate, seconds = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    puts: list[int] = []
    arrivals: list[int] = []
    bus = ZenohBus(ROBOT, endpoint)
    bus.subscribe("twist", lambda payload: arrivals.append(time.monotonic_ns()))
    for _ in paced(rate, WARM_UP + seconds):
        puts.append(time.monotonic_ns())
        bus.publish("ft", bytes(FT_BYTES))
        bus.publish("ee", bytes(EE_BYTES))
    time.sleep(0.2)
    bus.close()
    printed(puts, arrivals, puts[0] + round(WARM_UP * 1e9), puts[-1] + 1)


if __name__ == "__main__":
    main()
