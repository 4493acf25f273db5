"""Services as processes, as users start them: started, read, signalled and ended by their own id."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from signal import SIGTERM
from types import TracebackType

from tests.support.wait import eventually

ROOT = Path(__file__).resolve().parents[2]
LONGEST_END = 2.0
"""Time [s] within which the contract promises the end."""


class Process:
    """A running ``python -m <module>`` whose output goes to a file; a context manager that ends it."""

    def __init__(
        self,
        module: str,
        arguments: Sequence[str],
        output: Path,
        environment: dict[str, str] | None = None,
        python: str = sys.executable,
        within: Sequence[str] = (),
    ) -> None:
        """Starts the process.

        Args:
            module: such as ``services.wrench``, or the absolute path of a script or program.
            arguments: its command line.
            output: the file that standard output and standard error go to.
            environment: added to this process' environment, from which TANDEM_* is removed.
            python: the interpreter; empty for a program, which needs none.
            within: what its command begins with, such as another machine's.
        """
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("TANDEM_")}
        self.module = module
        self._output = output
        by = ([python] if python else []) + ([] if module.startswith("/") else ["-m"])
        with output.open("wb") as sink:
            self._process = subprocess.Popen(
                [*within, *by, module, *arguments],
                cwd=ROOT,
                env={**inherited, "PYTHONUNBUFFERED": "1", **(environment or {})},
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=subprocess.STDOUT,
            )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def output(self) -> str:
        """Everything that it has written so far."""
        return self._output.read_text(errors="replace")

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    def signal(self, number: signal.Signals) -> None:
        """Sends a signal, for example SIGKILL or SIGSTOP to inject a fault."""
        self._process.send_signal(number)

    def wait(self, timeout: float = 10.0) -> int:
        """Exit status, once it has ended by itself or by a signal sent before.

        Raises:
            AssertionError: if it still runs after ``timeout`` [s]; the message holds its output.
        """
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"{self.module} still runs after {timeout} s; its output:\n{self.output}") from None

    def wait_for_output(self, text: str, timeout: float = 20.0) -> None:
        """Returns once ``text`` stands in the output; fails early if the process ends without it."""
        eventually(lambda: text in self.output or not self.running, timeout, f"{self.module} writes {text!r}")
        assert text in self.output, f"{self.module} ended without writing {text!r}:\n{self.output}"

    def kill(self) -> None:
        """Ends it with SIGKILL."""
        self.signal(signal.SIGKILL)
        self.wait()

    def ends_in_time(self, number: signal.Signals = SIGTERM) -> None:
        """Ends it with a signal, as the contract promises: soon, with status 0 and without a traceback."""
        before = time.monotonic()
        self.signal(number)
        assert self.wait(20.0) == 0, self.output
        assert time.monotonic() - before < LONGEST_END
        assert "Traceback" not in self.output, self.output

    def refuses(self, *parts: str) -> None:
        """Waits for its end with status 2 and a single line, in which all of these are."""
        assert self.wait(20.0) == 2, self.output
        (line,) = self.output.splitlines()
        for part in parts:
            assert part in line, line

    def stop(self, timeout: float = 5.0) -> int:
        """Ends it with SIGTERM, after ``timeout`` [s] with SIGKILL, and returns the exit status."""
        if self.running:
            self._process.send_signal(signal.SIGCONT)
            self._process.terminate()
            try:
                self._process.wait(timeout)
            except subprocess.TimeoutExpired:
                self._process.kill()
        return self._process.wait()

    def __enter__(self) -> Process:
        """The process itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the process whatever happened."""
        self.stop()


class Processes(ExitStack):
    """Processes that end together, newest first; each writes to a file of its own in one folder."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._folder = folder
        self._numbers = itertools.count()

    def start(
        self,
        module: str,
        *arguments: str,
        environment: dict[str, str] | None = None,
        python: str = sys.executable,
        within: Sequence[str] = (),
    ) -> Process:
        """Starts ``python -m module arguments...``."""
        output = self._folder / f"{next(self._numbers)}-{Path(module).name}.log"
        return self.enter_context(Process(module, arguments, output, environment, python, within))

    def router(self, endpoint: str) -> Process:
        """Starts a router and waits until it listens on an endpoint."""
        router = self.start("services.router", "--listen", endpoint)
        router.wait_for_output(endpoint)
        return router
