"""What shows the drawing to whoever sits here: the desktop's browser, or rerun's own viewer."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from services.viewer.page import rerun_files
from shared.loop.config import Misconfigured

_ENDS_WITHIN = 2.0  # [s]


@contextmanager
def looked_at(url: str, source: str, browser: bool, native: bool) -> Iterator[Callable[[], bool]]:
    """Open what is asked for; gives a function that says whether it is still open, if that matters.

    Args:
        url: of the page.
        source: what rerun's own viewer shows, an address or a file.
        browser: whether to open the page, where there is a desktop.
        native: whether to start rerun's own viewer, with whose window all ends.

    Raises:
        Misconfigured: there is no such viewer.
    """
    if browser and desktop():
        # Some of them return only when they end.
        threading.Thread(target=webbrowser.open, args=(url,), name="browser", daemon=True).start()
    if not native:
        yield lambda: True
        return
    try:
        own = rerun_files.program()
    except rerun_files.Missing as problem:
        raise Misconfigured(f"--native: {problem}") from None
    # With CI it reports nothing to its makers, without its welcome it fetches no examples of theirs; its own server
    # takes part on this machine alone.
    command = [str(own), source, "--bind", "127.0.0.1", "--port", "auto", "--hide-welcome-screen"]
    viewer = subprocess.Popen(command, env={**os.environ, "CI": "1"})
    try:
        yield lambda: viewer.poll() is None
    finally:
        viewer.terminate()
        try:
            viewer.wait(_ENDS_WITHIN)
        except subprocess.TimeoutExpired:
            viewer.kill()


def desktop() -> bool:
    """Whether there is one on which a browser could open."""
    return sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
