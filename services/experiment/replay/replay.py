"""One service, given what a recording has for it, under a clock that shows what its own clock showed.

It takes the same messages between the same turns of its loop, and answers with the session that it had: what is alike
is alike byte by byte.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from services.experiment.replay.recorded import Answers, Life, Recorded, Said, outputs, read
from services.experiment.replay.subjects import SUBJECTS, make
from shared.clock import seconds
from shared.loop.diary import DONE, TURN, TURN_BEHIND, Entry, mark_of
from shared.loop.runner import Runner
from shared.parameters import Refused
from shared.requests import Setup
from shared.service import Output
from shared.topics import PARAMETER_QUERIES, Topic
from shared.wire.codec import Rejected, decode, decode_map, encode_map
from shared.wire.local import LocalBus, Scheduler
from shared.wire.log import NoRecording
from shared.wire.publisher import Publisher

Edit = Callable[[str, bytes], bytes]
"""Gives what a service is to hear under a key in place of a payload."""
_PARAMETERS = {query.key for query in PARAMETER_QUERIES}


@dataclass
class Replayed:
    """What a service answered.

    Attributes:
        answers: all but its health.
        missing: messages that it took when it was recorded, and that the recording did not hear.
    """

    answers: Answers = field(default_factory=dict)
    missing: int = 0


def replay(
    recorded: Recorded, life: Life, changes: Mapping[str, Any], edit: Edit = lambda key, payload: payload
) -> Replayed:
    """What a service answers from its start, or the first word of what it took, as far as it told that.

    Args:
        recorded: of the service.
        life: which of its starts.
        changes: parameters in place of those that it had, and that were set while it ran.
        edit: done to each message that it takes.

    Raises:
        Refused: a parameter is not as declared.
    """
    with tempfile.TemporaryDirectory() as folder:
        return _Replay(recorded, life, changes, edit, Path(folder)).played()


def complete(paths: Sequence[Path], service: str, asking: frozenset[str] = frozenset()) -> tuple[Recorded, int]:
    """What is recorded of a service, and how many messages that were not heard another service has said again.

    What a replay of that one says counts only if it is what the service took, by its check sum.

    Args:
        paths: the recording's files in their order.
        service: its name.
        asking: services that wait for this one's answers.

    Raises:
        NoRecording, OSError: as ``read``.
    """
    recorded = read(paths, service)
    unheard, before = {*recorded.unheard()}, len(recorded.payloads)
    keys = {key for key, _ in unheard}
    for other in SUBJECTS.keys() - {service, *asking}:
        if keys.isdisjoint(topic.key for topic in outputs(other)):
            continue
        # What it needs may not be installed here.
        with suppress(NoRecording, Refused, ModuleNotFoundError):
            source, _ = complete(paths, other, asking | {service})
            for life in source.lives:
                for key, answers in replay(source, life, {}).answers.items():
                    said = {(key, mark_of(answer.payload)): answer.payload for answer in answers.values()}
                    recorded.payloads.update({one: said[one] for one in said.keys() & unheard})
    return recorded, len(recorded.payloads) - before


class _Clock:
    """Shows what it is set to."""

    def __init__(self) -> None:
        self.now = 0

    def now_ns(self) -> int:
        return self.now


class _Bus(LocalBus):
    """A bus whose payloads are there at once, and on which whoever was recorded is present."""

    def __init__(self, clock: _Clock, recorded: Recorded) -> None:
        super().__init__(Scheduler())
        self._clock, self._others = clock, recorded.present

    def publish(self, key: str, payload: bytes) -> None:
        for take in self._subscribers.get(key, ()):
            take(payload)

    def present(self) -> Mapping[int, str]:
        return {session: name for since, session, name in self._others if since <= self._clock.now}


class _Replay:
    """One life of a service."""

    def __init__(self, recorded: Recorded, life: Life, changes: Mapping[str, Any], edit: Edit, folder: Path) -> None:
        self._recorded, self._life, self._changes, self._edit = recorded, life, changes, edit
        self._clock = _Clock()
        self._bus = _Bus(self._clock, recorded)
        self._found = Replayed()
        for topic in outputs(recorded.service):
            self._bus.subscribe(topic.key, partial(self._hear, topic))
        self._service = make(recorded.service, life.told[0].setup, changes, folder, lambda: seconds(self._clock.now))
        self._done = 0
        for call in ("step", "brake"):
            setattr(self._service, call, partial(self._lasting, getattr(self._service, call)))

    def played(self) -> Replayed:
        """Lets the whole life pass."""
        requests = self._life.requests()
        runner: Runner | None = None
        for entry, key, done in _with_end(self._life.entries()):
            self._clock.now = entry.time
            if runner is None:
                publisher = Publisher(self._bus, self._clock)
                publisher.session = self._life.session
                runner = Runner(self._service, self._bus, self._clock, publisher=publisher)
            if key:
                self._give(key, entry.mark)
            elif entry.what in (TURN, TURN_BEHIND):
                for asked in requests.pop(entry.time, ()):
                    self._bus.query_later(asked.query, self._kept(asked), lambda reply: None)
                self._done = done
                runner.poll(entry.what == TURN_BEHIND)
        return self._found

    def _give(self, key: str, mark: int) -> None:
        payload = self._recorded.payloads.get((key, mark))
        if payload is None:
            self._found.missing += 1
        else:
            self._bus.publish(key, self._edit(key, payload))

    def _lasting(self, call: Callable[..., Iterable[Output]], *given: Any) -> Iterator[Output]:
        """A step or a brake that lasts as long as it did."""
        yield from call(*given)
        self._clock.now = self._done

    def _kept(self, asked: Setup) -> bytes:
        """A request, which sets no parameter that is changed for good."""
        if asked.query not in _PARAMETERS or not self._changes:
            return asked.request
        try:
            request = decode_map(asked.request)
            wanted = {name: value for name, value in request["set"].items() if name not in self._changes}
        except (Rejected, KeyError, AttributeError):
            return asked.request
        return encode_map({**request, "set": wanted})

    def _hear(self, topic: Topic, payload: bytes) -> None:
        header, _ = decode(topic.message, payload, topic.cap)
        # It may hear others under the same key.
        if header.session == self._life.session:
            self._found.answers.setdefault(topic.key, {})[header.stamp] = Said(header, bytes(payload))


def _with_end(happened: Iterable[tuple[int, Entry, str]]) -> Iterator[tuple[Entry, str, int]]:
    """Each entry with its key, and for a turn when its step was over [ns], which is noted after it."""
    waiting: list[tuple[Entry, str]] = []
    for what, entry, key in happened:
        if what == DONE or (what in (TURN, TURN_BEHIND) and waiting):
            for one, its_key in waiting:
                yield one, its_key, entry.time if what == DONE else one.time
            waiting = []
        if what in (TURN, TURN_BEHIND) or (what != DONE and waiting):
            waiting.append((entry, key))
        elif what != DONE:
            yield entry, key, entry.time
    for one, its_key in waiting:
        yield one, its_key, one.time
