"""The only module of a replay that imports what is replayed: when the sources move, its imports move with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import shared
from services.base.base import Base
from services.base.parameters import BaseParameters
from services.controller.controller import Controller
from services.controller.parameters import ControllerParameters
from services.task.parameters import TaskParameters
from services.task.task import Task
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.loop.runner import Runner
from shared.loop.stack import Stack
from shared.service import Service

LATENCY = 0.0005  # [s] of every message, about what the router takes
CODE = Path(next(iter(shared.__path__))).resolve().parent
"""Where the replayed sources lie."""


class Product:
    """The services under a simulated clock; everything that goes in or out is bytes.

    Args:
        settings: parameters of each service that runs, in the order in which they start.
        folder: where the services keep what outlives them.
    """

    def __init__(self, settings: Mapping[str, Mapping[str, Any]], folder: Path) -> None:
        self._stack = Stack(LATENCY)
        self._settings = settings
        self._folder = folder
        self._runners: dict[str, Runner] = {}
        for name in settings:
            self.start(name)

    def start(self, name: str) -> None:
        """Start a service; one that runs already is killed before."""
        if name in self._runners:
            self._stack.kill(self._runners[name])
        self._runners[name] = self._stack.add(self._service(name, self._settings[name]))

    def _service(self, name: str, settings: Mapping[str, Any]) -> Service:
        if name == "wrench":
            return Wrench(WrenchParameters.of(settings), self._folder)
        if name == "controller":
            return Controller(ControllerParameters.of(settings))
        if name == "base":
            return Base(BaseParameters.of(settings))
        if name == "task":
            return Task(TaskParameters.of(settings), lambda: self.now * 1e-9, self._folder)
        raise ValueError(f"there is no service {name!r} to replay")

    @property
    def now(self) -> int:
        """Simulated time [ns]."""
        return self._stack.scheduler.clock.now_ns()

    def at(self, time: int, action: Callable[[], None]) -> None:
        """Have something done at a simulated time [ns]."""
        self._stack.scheduler.at(time, action)

    def run_until(self, time: int) -> None:
        """Let simulated time pass [ns]."""
        self._stack.scheduler.run_until(time)

    def publish(self, key: str, payload: bytes) -> None:
        """Put a message on the bus."""
        self._stack.bus.publish(key, payload)

    def hear(self, key: str, on_payload: Callable[[bytes], None]) -> None:
        """Have every message under a key handed over."""
        self._stack.bus.subscribe(key, on_payload)

    def ask(self, key: str, payload: bytes, on_reply: Callable[[bytes], None]) -> bool:
        """Send a query; false if nobody serves it."""
        return self._stack.bus.query_later(key, payload, on_reply)
