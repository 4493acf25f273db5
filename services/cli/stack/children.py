"""Processes that a command starts: their output is kept, their end noticed, and none outlives the command."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType

from shared.loop.tether import tethered
from shared.processes import process_named

KEPT_LINES = 200  # of a process's output, for whoever asks how it ended
STOP_PATIENCE = 3.0  # [s] after SIGTERM, before SIGKILL; every service promises 2 s


class Child:
    """One `python -m services.<name>`, in a process group of its own so that Ctrl-C reaches this command only.

    Start children from the main thread: the kernel's notice of a parent's death is about the thread that forked.
    """

    def __init__(
        self, name: str, arguments: Sequence[str], log: Path | None = None, on_line: Callable[[str], None] | None = None
    ) -> None:
        """Starts it. Its output is kept, copied to the file `log`, and handed line by line to `on_line`."""
        self.name = name
        self.arguments = list(arguments)
        self.lines: deque[str] = deque(maxlen=KEPT_LINES)
        self.started = time.monotonic()
        self._log = log
        self._on_line = on_line
        module = process_named(name).module
        self._process = subprocess.Popen(
            tethered([sys.executable, "-m", module, *arguments]),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            process_group=0,
        )
        self._reader = threading.Thread(target=self._read, name=f"output of {name}", daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        sink = self._log.open("w", encoding="utf-8") if self._log else None
        for line in self._process.stdout:
            self.lines.append(line.rstrip())
            if sink:
                sink.write(line)
                sink.flush()
            if self._on_line:
                self._on_line(line.rstrip())
        if sink:
            sink.close()

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def status(self) -> int | None:
        """Exit status, negative for a signal; None while it runs."""
        return self._process.poll()

    @property
    def last_line(self) -> str:
        """The last thing it printed, empty if nothing."""
        return next((line for line in reversed(self.lines) if line), "")

    def how_it_ended(self) -> str:
        """In words: exit status or signal, and the last line it printed; empty while it runs."""
        status = self.status
        if status is None:
            return ""
        self._reader.join(0.5)
        cause = f"status {status}" if status >= 0 else f"signal {signal.Signals(-status).name}"
        return f"ended with {cause}" + (f": {self.last_line}" if self.last_line else "")

    def terminate(self) -> None:
        """Asks it to end; a stopped process is woken for that."""
        if self.status is None:
            self._process.send_signal(signal.SIGTERM)
            self._process.send_signal(signal.SIGCONT)

    def finish(self, deadline: float) -> int:
        """Waits until `deadline` (steady clock, s), then kills it; returns the exit status."""
        try:
            self._process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(1.0)
        return self._process.returncode


class Children:
    """Several of them, ended together and in reverse order of their start; a context manager."""

    def __init__(self) -> None:
        """None yet."""
        self._children: list[Child] = []

    def start(self, child: Child) -> Child:
        """Takes charge of a child."""
        self._children.append(child)
        return child

    def __iter__(self) -> Iterator[Child]:
        """In order of start."""
        return iter(self._children)

    def stop(self) -> list[Child]:
        """Ends all; returns those that had to be killed or ended with a status other than 0 on SIGTERM."""
        running = [child for child in reversed(self._children) if child.status is None]
        for child in running:
            child.terminate()
        deadline = time.monotonic() + STOP_PATIENCE
        return [child for child in running if child.finish(deadline) != 0]

    def __enter__(self) -> Children:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends all whatever happened."""
        self.stop()
