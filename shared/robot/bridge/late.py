"""What was on its way to the robot when that way broke is given up instead of delivered late.

TCP keeps what it could not deliver, and delivers all of it at once when the way is mended: controllers that begin a
trajectory on its arrival would then carry out, in a moment, what was commanded before the robot came to rest.
"""

from __future__ import annotations

import os
import socket
from contextlib import suppress

GIVEN_UP_AFTER = 200
"""[ms] without an answer after which a connection ends, and all that waits in it: less than a robot goes on for."""


def give_up_late(connection: socket.socket) -> None:
    """Have a TCP connection end instead of delivering late; Linux alone can do that."""
    if hasattr(socket, "TCP_USER_TIMEOUT"):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, GIVEN_UP_AFTER)


def give_up_late_to(port: int) -> None:
    """The same for every connection of this process to a port: a library may keep its sockets to itself."""
    # Descriptors that are no sockets, are not connected or have been closed since are none of its.
    for number in os.listdir("/proc/self/fd") if os.path.isdir("/proc/self/fd") else ():
        with suppress(OSError):
            copy = os.dup(int(number))
            try:
                connection = socket.socket(fileno=copy)
            except OSError:
                os.close(copy)
                continue
            with connection:
                if connection.family in (socket.AF_INET, socket.AF_INET6) and connection.getpeername()[1] == port:
                    give_up_late(connection)
