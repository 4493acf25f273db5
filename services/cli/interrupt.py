"""Ending a command in the foreground."""

from __future__ import annotations

import signal
import threading


def stop_event() -> threading.Event:
    """An event that Ctrl-C and SIGTERM set."""
    event = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: event.set())
    return event
