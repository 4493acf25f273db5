"""A function in a process of its own: it disturbs no running stack, and ends with the command whatever ends that."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class NoResult(Exception):
    """The function raised something, took too long, or its process ended; the text says it in one line."""


class Background(Generic[T]):
    """Calls a function with arguments in another process.

    Args:
        function: a module's own function; it and what it returns are pickled.
        arguments: of it.
        log: file that its process prints to.
        patience: how long it may take [s].
    """

    def __init__(self, function: Callable[..., T], *arguments: Any, log: Path, patience: float) -> None:
        context = get_context("spawn")
        self._log = log
        self._patience = patience
        self._deadline = time.monotonic() + patience
        self._answer, theirs = context.Pipe(duplex=False)
        self._process = context.Process(target=_call, args=(theirs, os.getpid(), log, function, arguments), daemon=True)
        self._process.start()
        theirs.close()

    @property
    def busy(self) -> bool:
        """Whether there is no result yet."""
        waits = self._process.is_alive() and not self._answer.poll()
        return waits and time.monotonic() < self._deadline

    def result(self) -> T:
        """Result of the function, once it is not busy.

        Raises:
            NoResult: there is none; the text says why.
        """
        if self._process.is_alive() and not self._answer.poll():
            self.end()
            raise NoResult(f"it took over {self._patience:.0f} s")
        try:
            problem, value = self._answer.recv()
        except EOFError:
            self._process.join()
            raise NoResult(f"its process ended with status {self._process.exitcode}, see {self._log}") from None
        if problem:
            raise NoResult(problem)
        return value

    def end(self) -> None:
        """Ends the process, done or not."""
        self._process.kill()


def _call(answer: Connection, parent: int, log: Path, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """In the other process: behind everybody else, out of Ctrl-C's reach, and gone when the command is."""
    os.setpgid(0, 0)
    os.nice(19)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
    if os.getppid() != parent:
        return
    with log.open("w", encoding="utf-8") as sink:
        # The physics engine prints past Python's own streams.
        for stream in (1, 2):
            os.dup2(sink.fileno(), stream)
        try:
            answer.send(("", function(*arguments)))
        except Exception as problem:
            traceback.print_exc()
            answer.send((" ".join(str(problem).split()) or type(problem).__name__, None))
