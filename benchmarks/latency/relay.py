"""One hop with nothing in it: ``python -m benchmarks.latency.relay <endpoint> <from> <to> <bytes> [<also> ...]``.

It receives as the services do, in a thread of its own that takes the newest sample, and puts a ready payload of the
size that the service would have put. Keys after the size are subscribed to and dropped, as side traffic of the hop.
"""

from __future__ import annotations

import json
import signal
import sys
import threading

import zenoh


def open_session(endpoint: str) -> zenoh.Session:
    """A client of the router at ``endpoint``, Zenoh's own settings otherwise."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def main() -> None:
    """Relay until SIGTERM."""
    endpoint, source, target, size, *also = sys.argv[1:]
    done = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: done.set())
    with open_session(endpoint) as session:
        publisher = session.declare_publisher(
            target,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
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


if __name__ == "__main__":
    main()
