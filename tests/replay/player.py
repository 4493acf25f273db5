"""Replays a case and hears what the services say to it."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import msgpack

from tests.replay.cases import Case
from tests.replay.product import Product
from tests.replay.recordings import Event

HEARD = (
    "wrench/external",
    "command/ee_twist",
    "command/base_twist",
    "command/gripper",
    "command/head",
    "control/target",
    "control/status",
    "base/status",
    "base/enable",
    "task/status",
    "stop",
    *(f"health/{service}" for service in ("wrench", "controller", "base", "task")),
)


class Said(NamedTuple):
    """A message of a service, or its reply to a query: when it was heard [ns], and the whole map."""

    time: int
    content: dict[str, Any]


Answers = dict[str, list[Said]]
"""What was said under each key; replies stand under ``reply`` and the query's key."""


def play(case: Case) -> Answers:
    """What the services say to a case."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return _Replay(case, folder).answers()


class _Replay:
    """One replay in a folder of its own."""

    def __init__(self, case: Case, folder: Path) -> None:
        self._case = case
        self._folder = folder
        self._answers: Answers = {}
        # A payload's file is copied: an identification would write to it.
        for path in case.inputs.glob("payload*.toml"):
            shutil.copy(path, folder)
        self._product = Product({name: self._placed(settings) for name, settings in case.services.items()}, folder)

    def answers(self) -> Answers:
        """Lets the whole case pass."""
        product, case = self._product, self._case
        events = case.events()
        given = {event.key for event in events if not event.asked}
        for key in HEARD:
            if key not in given:
                product.bus.subscribe(key, self._listener(key))
        for event in events:
            product.scheduler.at(event.time, partial(self._put, event))
        for time, service in case.restarts:
            product.scheduler.at(time, partial(product.start, service))
        product.scheduler.run_until(round(case.end * 1e9))
        return self._answers

    def _put(self, event: Event) -> None:
        payload = msgpack.packb(event.content)
        if not event.asked:
            self._product.bus.publish(event.key, payload)
        elif not self._product.bus.query_later(event.key, payload, self._listener(f"reply {event.key}")):
            raise LookupError(f"{self._case.name}: nobody serves {event.key}")

    def _listener(self, key: str) -> Callable[[bytes], None]:
        said = self._answers.setdefault(key, [])
        return lambda payload: said.append(Said(self._product.now, self._normal(msgpack.unpackb(payload))))

    def _normal(self, content: dict[str, Any]) -> dict[str, Any]:
        """Without what differs from one replay to the next: the session, drawn at random, and the folder's name."""
        return self._named({name: value for name, value in content.items() if name != "session"})

    def _named(self, value: Any) -> Any:
        if isinstance(value, str):
            return value.replace(str(self._folder), "FOLDER")
        if isinstance(value, dict):
            return {name: self._named(item) for name, item in value.items()}
        return [self._named(item) for item in value] if isinstance(value, list) else value

    def _placed(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        return {
            name: value.replace("FOLDER", str(self._folder)) if isinstance(value, str) else value
            for name, value in settings.items()
        }


def digests(answers: Answers) -> dict[str, tuple[str, int]]:
    """For each key under which anything was said, a checksum of every bit with its time, and the number of messages."""
    return {key: (_digest(said), len(said)) for key, said in sorted(answers.items()) if said}


def _digest(said: list[Said]) -> str:
    digest = hashlib.sha256()
    for time, content in said:
        digest.update(msgpack.packb([time, _sorted(content)]))
    return digest.hexdigest()


def _sorted(value: Any) -> Any:
    """The order of a map's names is no behaviour."""
    if isinstance(value, dict):
        return {name: _sorted(item) for name, item in sorted(value.items())}
    return [_sorted(item) for item in value] if isinstance(value, list) else value
