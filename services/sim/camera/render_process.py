"""A process of its own for the camera's pictures: to render one takes longer than the wrist's sensor may be silent.

Run as ``python -m services.sim.camera.render_process FD``: it takes what there is to see from that connection, sends
images back, and ends when the other end is closed.
"""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from multiprocessing.connection import Connection

from services.sim.camera.renderer import Renderer
from services.sim.camera.view import Scenery, View

ENDED = "no pictures: the process that renders them has ended"


class RenderProcess:
    """Has another process render, which is started for the first picture.

    Attributes:
        complaint: why there are no pictures any more, or "".

    Args:
        scenery: what does not change.
    """

    def __init__(self, scenery: Scenery) -> None:
        self._scenery = scenery
        self._connection: Connection | None = None
        self.complaint = ""

    def begin(self, view: View) -> None:
        """Begin with a picture."""
        try:
            if self._connection is None:
                self._connection = self._opened()
            self._connection.send(view)
        except OSError:
            self.complaint = ENDED

    def picture(self) -> bytes | None:
        """The picture begun as a JPEG image, once, when it is ready."""
        if self._connection is None:
            return None
        try:
            return self._connection.recv_bytes() if self._connection.poll() else None
        except (EOFError, OSError):
            self.complaint = ENDED
            return None

    def _opened(self) -> Connection:
        ours, theirs = socket.socketpair()
        with theirs:
            descriptor = theirs.fileno()
            # Its standard output would get the physics engine's greeting once more.
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, str(descriptor)],
                pass_fds=[descriptor],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
            )
        connection = Connection(ours.detach())
        connection.send(self._scenery)
        return connection


def main(descriptor: int) -> None:
    """Render until the other end is closed."""
    # An interrupt from the keyboard reaches this process too; it is the other one that decides when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    connection = Connection(descriptor)
    try:
        renderer = Renderer(connection.recv())
        while True:
            connection.send_bytes(renderer.jpeg(connection.recv()))
    except (EOFError, OSError):
        return


if __name__ == "__main__":
    main(int(sys.argv[1]))
