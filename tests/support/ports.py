"""Free ports on the loopback interface, and a client of Zenoh that knows nothing of the project's own bus."""

from __future__ import annotations

import json
import socket

import zenoh


def free_port() -> int:
    """A TCP port of the loopback interface that nobody listens on at this moment."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def free_pair() -> int:
    """A free port of the loopback interface of which the next one is free, too."""
    while True:
        port = free_port()
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port + 1))
            except OSError:
                continue
            return port


def free_endpoint() -> str:
    """A Zenoh endpoint on a free loopback port, such as ``tcp/127.0.0.1:41235``."""
    return f"tcp/127.0.0.1:{free_port()}"


def open_session(endpoint: str) -> zenoh.Session:
    """A client of the router at an endpoint, Zenoh's own settings otherwise."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)
