"""The services that can be replayed: pure ones, whose answers depend on nothing but what they are given."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

from services.task.journal import boot_id
from services.wrench.storage import PAYLOAD
from shared.requests import Setup
from shared.service import Service

Given = tuple[Mapping[str, Any], Collection[str]]
"""Parameters by their names, and the names of those that are not just defaults."""
Make = Callable[[Given, Path, Callable[[], float]], Service]
"""Makes a service of its parameters, the folder for what it keeps, and the clock [s] that a journal is written by.

Raises ``shared.parameters.Refused``: a parameter is not as declared.
"""


def _wrench(given: Given, folder: Path, now: Callable[[], float]) -> Service:
    from services.wrench.parameters import WrenchParameters
    from services.wrench.wrench import Wrench

    return Wrench(WrenchParameters.restored(*given), folder)


def _controller(given: Given, folder: Path, now: Callable[[], float]) -> Service:
    from services.controller.controller import Controller
    from services.controller.parameters import ControllerParameters

    return Controller(ControllerParameters.restored(*given))


def _base(given: Given, folder: Path, now: Callable[[], float]) -> Service:
    from services.base.base import Base
    from services.base.parameters import BaseParameters

    return Base(BaseParameters.restored(*given))


def _task(given: Given, folder: Path, now: Callable[[], float]) -> Service:
    from services.task.parameters import TaskParameters
    from services.task.task import Task

    return Task(TaskParameters.restored(*given), now, folder)


# Each imports what it needs itself: who replays a controller has no camera to look through.
SUBJECTS: dict[str, Make] = {"wrench": _wrench, "controller": _controller, "base": _base, "task": _task}


def make(name: str, setup: Setup, changes: Mapping[str, Any], folder: Path, now: Callable[[], float]) -> Service:
    """The service of a name as it was when it told its setup, but for changed parameters.

    Args:
        name: one of ``SUBJECTS``.
        setup: that it told.
        changes: parameters in place of those.
        folder: empty, for its files.
        now: clock [s].

    Raises:
        Refused: a parameter is not as declared.
    """
    parameters, files = {**setup.parameters, **changes}, setup.files
    if (payload := str(setup.parameters.get("payload", ""))) and "payload" not in changes:
        # A path of the machine that recorded; the file came along.
        parameters["payload"] = str(folder / PAYLOAD)
        files = {at: text.replace(json.dumps(payload), json.dumps(parameters["payload"])) for at, text in files.items()}
    for at, text in files.items():
        path = folder / at
        # A recording may come from anybody.
        if path.resolve().is_relative_to(folder.resolve()):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(_of_this_boot(text), encoding="utf-8")
    return SUBJECTS[name]((parameters, {*setup.chosen, *changes}), folder, now)


def _of_this_boot(content: str) -> str:
    """A journal's times count within a boot, which the replay stands for."""
    try:
        plain = json.loads(content)
    except ValueError:
        return content
    return json.dumps({**plain, "boot": boot_id()}) if isinstance(plain, dict) and "boot" in plain else content
