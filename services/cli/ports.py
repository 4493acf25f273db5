"""Ports of this machine: the page's, and whether one can be listened on."""

from __future__ import annotations

import socket

PAGE = 9090
"""Of the viewer's page, and one above of its picture."""


def taken(port: int, host: str = "127.0.0.1") -> OSError | None:
    """Why a port cannot be listened on; None if it can."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as problem:
            return problem
    return None
