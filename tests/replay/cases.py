"""What is recorded: a robot, the services that hear it with their parameters, and what is done to it before.

All of it lies in ``cases.toml``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tests.replay.events import Event

Edit = Mapping[str, Any]
Changed = list[Event]
HERE = Path(__file__).parent
ROBOT = ("sensor/", "state/")
"""How the keys of the robot's process begin."""
SOMEBODY = 77
"""The session of messages that an edit adds."""


@dataclass(frozen=True)
class Case:
    """One recording.

    Attributes:
        name: of it.
        robot: the name of the run in which the robot was heard.
        services: parameters of each service, in the order in which they start.
        end: simulated time [s] at which it ends.
        edits: what is done to the recording.
        restarts: times [ns] and names of services that are killed and started anew.
    """

    name: str
    robot: str
    services: Mapping[str, Mapping[str, Any]]
    end: float
    edits: tuple[Edit, ...]
    restarts: tuple[tuple[int, str], ...]

    def edited(self, events: Iterable[Event]) -> list[Event]:
        """What is put on the bus in place of what a robot and people said, in order of time."""
        changed = list(events)
        for edit in self.edits:
            changed = _EDITS[edit["do"]](changed, edit)
        end = _ns(self.end)
        return sorted((event for event in changed if event.time <= end), key=lambda event: event.time)


def cases() -> list[Case]:
    """All of them."""
    with (HERE / "cases.toml").open("rb") as file:
        content = tomllib.load(file)
    return [_case(name, given) for name, given in content.items()]


def _case(name: str, given: dict[str, Any]) -> Case:
    edits = given.get("edits", [])
    restarts = [(_ns(edit["at"]), edit["service"]) for edit in edits if edit["do"] == "restart"]
    others = tuple(edit for edit in edits if edit["do"] != "restart")
    return Case(name, given["robot"], given["services"], given["end"], others, tuple(restarts))


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)


def _concerns(event: Event, edit: Edit) -> bool:
    return (
        not event.asked
        and event.key.startswith(edit.get("key", ""))
        and _ns(edit.get("from", 0.0)) <= event.time < _ns(edit.get("to", 1e9))
    )


def _drop(events: Changed, edit: Edit) -> Changed:
    return [event for event in events if not _concerns(event, edit)]


def _set(events: Changed, edit: Edit) -> Changed:
    return [
        replace(event, content={**event.content, **edit["map"]}) if _concerns(event, edit) else event
        for event in events
    ]


def _late(events: Changed, edit: Edit) -> Changed:
    by = _ns(edit["by"])
    return [replace(event, time=event.time + by) if _concerns(event, edit) else event for event in events]


def _add(events: Changed, edit: Edit) -> Changed:
    time = _ns(edit["at"])
    before = sum(event.key == edit["key"] and event.content["session"] == SOMEBODY for event in events)
    header = {"seq": before, "session": SOMEBODY, "stamp": time, "valid": True}
    return [*events, Event(time, edit["key"], {**header, **edit["map"]})]


def _ask(events: Changed, edit: Edit) -> Changed:
    return [*events, Event(_ns(edit["at"]), edit["key"], dict(edit["map"]), asked=True)]


def _robot_restarts(events: Changed, edit: Edit) -> Changed:
    """The robot's process begins anew: another session, and its messages are numbered from 0."""
    first: dict[str, int] = {}
    changed = []
    for event in events:
        if event.time >= _ns(edit["at"]) and not event.asked and event.key.startswith(ROBOT):
            content = event.content
            number = content["seq"] - first.setdefault(event.key, content["seq"])
            event = replace(event, content={**content, "seq": number, "session": content["session"] + 1})
        changed.append(event)
    return changed


_EDITS: dict[str, Callable[[Changed, Edit], Changed]] = {
    "drop": _drop,
    "set": _set,
    "late": _late,
    "add": _add,
    "ask": _ask,
    "robot_restarts": _robot_restarts,
}
