"""Connections to a robot give up what they could not deliver in time."""

from __future__ import annotations

import os
import socket
from contextlib import ExitStack

from shared.robot.bridge.late import GIVEN_UP_AFTER, give_up_late_to


def test_every_connection_to_a_port_gives_up_and_no_other() -> None:
    with ExitStack() as open_:
        listeners = [open_.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(2)]
        robot, other = (open_.enter_context(socket.create_connection(listener.getsockname())) for listener in listeners)
        descriptors = len(os.listdir("/proc/self/fd"))
        give_up_late_to(listeners[0].getsockname()[1])
        told = [one.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) for one in (robot, other, *listeners)]
        assert told == [GIVEN_UP_AFTER, 0, 0, 0]
        assert len(os.listdir("/proc/self/fd")) == descriptors
        robot.sendall(b"it goes on")
