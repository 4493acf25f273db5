"""An object that lives in a process of its own, where each call of a method is carried out."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeVar

T = TypeVar("T")
_PATIENCE = 30.0  # [s] for an answer


class Elsewhere(Generic[T]):
    """What ``make(*arguments)`` makes, in a process of its own; a context manager that ends it.

    Whatever is called on it is called there: ``robot.joints()``. Arguments and results are copies.
    """

    def __init__(self, make: Callable[..., T], *arguments: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._here, there = context.Pipe()
        self._process = context.Process(target=_serve, args=(there, make, arguments), daemon=True)
        self._process.start()
        there.close()

    @property
    def pid(self) -> int:
        """Of its process."""
        assert self._process.pid is not None
        return self._process.pid

    def signal(self, number: signal.Signals) -> None:
        """Send it a signal."""
        os.kill(self.pid, number)

    def kill(self) -> None:
        """End it as a fault does, and wait for that."""
        self.signal(signal.SIGKILL)
        self._process.join()

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            self._here.send((name, arguments))
            assert self._here.poll(_PATIENCE), f"no answer to {name} within {_PATIENCE} s"
            result = self._here.recv()
            if isinstance(result, Exception):
                raise result
            return result

        return call

    def __enter__(self) -> Elsewhere[T]:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process.is_alive():
            self.kill()
        self._here.close()


def _serve(connection: Connection, make: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """Carry out calls until nobody is there to make any."""
    made = make(*arguments)
    while True:
        try:
            name, given = connection.recv()
        except EOFError:
            return
        try:
            connection.send(getattr(made, name)(*given))
        except Exception as problem:
            connection.send(problem)
