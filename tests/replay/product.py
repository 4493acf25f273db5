"""The only module of a replay that imports what is replayed: when the sources move, its imports move with them."""

from __future__ import annotations

from collections.abc import Mapping
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

    Attributes:
        bus: of bytes: ``publish``, ``subscribe``, and ``query_later``, which is false if nobody serves a query.
        scheduler: ``at(time, action)`` and ``run_until(time)``, times in simulated [ns].
    """

    def __init__(self, settings: Mapping[str, Mapping[str, Any]], folder: Path) -> None:
        self._stack = Stack(LATENCY)
        self.bus, self.scheduler = self._stack.bus, self._stack.scheduler
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
        match name:
            case "wrench":
                return Wrench(WrenchParameters.of(settings), self._folder)
            case "controller":
                return Controller(ControllerParameters.of(settings))
            case "base":
                return Base(BaseParameters.of(settings))
            case "task":
                return Task(TaskParameters.of(settings), lambda: self.now * 1e-9, self._folder)
        raise ValueError(f"there is no service {name!r} to replay")

    @property
    def now(self) -> int:
        """Simulated time [ns]."""
        return self.scheduler.clock.now_ns()
