"""As many hops as the chain has, with nothing in them, and their source and sink.

``python -m benchmarks.latency.relay hop <endpoint> <from> <to> <bytes> [<also> ...]`` receives as the services do, in a
thread of its own that takes the newest sample, and puts a ready payload of the size that the service would have put.
Keys after the size are subscribed to and dropped, as side traffic of the hop.
``python -m benchmarks.latency.relay probe <endpoint> <rate> <seconds>`` prints the latencies.
"""

from __future__ import annotations

import signal
import sys
import threading
import time

import zenoh

from benchmarks.latency.pacing import probed
from shared.wire.zenoh import ZenohBus
from tests.support.ports import open_session

ROBOT = "floor"
FT_BYTES, WRENCH_BYTES, TWIST_BYTES, EE_BYTES = 214, 209, 129, 202
"""Sizes [bytes] of sensor/ft, wrench/external, command/ee_twist and state/ee on the wire."""


def hop(endpoint: str, source: str, target: str, size: str, *also: str) -> None:
    """Relay until SIGTERM."""
    done = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: done.set())
    with open_session(endpoint) as session:
        publisher = session.declare_publisher(
            target, congestion_control=zenoh.CongestionControl.DROP, priority=zenoh.Priority.REAL_TIME, express=True
        )
        payload = bytes(int(size))
        for key in also:
            session.declare_subscriber(key, zenoh.handlers.Callback(lambda sample: sample.payload.to_bytes()))
        subscriber = session.declare_subscriber(source, zenoh.handlers.RingChannel(1))

        def relay() -> None:
            for sample in subscriber:
                sample.payload.to_bytes()
                publisher.put(payload)

        threading.Thread(target=relay, daemon=True).start()
        print("ready", flush=True)
        while not done.wait(0.5):
            pass


def probe(endpoint: str, rate: str, seconds: str) -> None:
    """Print the latencies [us] as JSON."""
    bus = ZenohBus(ROBOT, endpoint)
    arrivals: list[int] = []
    bus.subscribe("twist", lambda payload: arrivals.append(time.monotonic_ns()))

    def put() -> None:
        bus.publish("ft", bytes(FT_BYTES))
        bus.publish("ee", bytes(EE_BYTES))

    probed(float(rate), float(seconds), put, arrivals)
    bus.close()


if __name__ == "__main__":
    {"hop": hop, "probe": probe}[sys.argv[1]](*sys.argv[2:])
