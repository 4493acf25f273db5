"""Free ports on the loopback interface."""

from __future__ import annotations

import socket


def free_port() -> int:
    """A TCP port of the loopback interface that nobody listens on at this moment."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def free_endpoint() -> str:
    """A Zenoh endpoint on a free loopback port, such as ``tcp/127.0.0.1:41235``."""
    return f"tcp/127.0.0.1:{free_port()}"
