"""One configuration of the stack under which an experiment is played."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Run:
    """What the stack is started with.

    Attributes:
        name: of the run and of its folder.
        title: for people.
        law: of the controller.
        rate: of the force-torque sensor [Hz].
        settings: the parameters that differ from the services' defaults: service -> parameter -> value.
        further: services that it needs besides those of every stack.
    """

    name: str
    title: str
    law: str
    rate: float
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    further: tuple[str, ...] = ()
