"""What a recording has of one service: how it was set up, what it took and when, what was asked of it, what it said.

A recording hears a message at another moment than a service that takes it, or not at all. But a service tells under
`setup/` what it took, in which order and when by its own clock, to the nanosecond, and that is what counts.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from shared.loop.diary import BEGUN, Entry, entries, mark_of
from shared.messages import Header
from shared.processes import HEALTHY, publisher_named
from shared.requests import Setup
from shared.topics import SENSOR_CAMERA, TOPICS, Topic, setup_topic, topic_by_key
from shared.wire.codec import Rejected, decode
from shared.wire.log import Heard, Log, NoRecording


class Said(NamedTuple):
    """An answer."""

    header: Header
    payload: bytes


Answers = dict[str, dict[int, Said]]
"""By key, by stamp [ns], what a service says."""


class Told(NamedTuple):
    """A setup as a service told it."""

    header: Header
    setup: Setup


@dataclass
class Life:
    """One start of a service, as far as it was recorded.

    Attributes:
        session: that tells it from others.
        told: its setups, in their order.
        answers: all that it said but its health.
        lost: answers that are missing between two that were heard.
    """

    session: int
    told: list[Told] = field(default_factory=list)
    answers: Answers = field(default_factory=dict)
    lost: int = 0

    @property
    def whole(self) -> bool:
        """Whether its start was recorded."""
        return next(self.entries(), (None,))[0] == BEGUN

    @property
    def gaps(self) -> int:
        """How often a second or more of what it took was not told to the recording."""
        numbers = [told.header.seq for told in self.told]
        return sum(after != before + 1 for before, after in pairwise(numbers))

    @property
    def known_until(self) -> int:
        """Time [ns] up to which it told what it took."""
        return self.told[-1].header.stamp

    def entries(self) -> Iterator[tuple[int, Entry, str]]:
        """Kind, entry and key of all that happened to it; the key is empty if it is no arrival."""
        for told in self.told:
            keys = told.setup.inputs
            for entry in entries(told.setup.diary):
                if entry.what < len(keys):
                    yield entry.what, entry, keys[entry.what] if entry.what >= 0 else ""

    def requests(self) -> dict[int, list[Setup]]:
        """By the time [ns] of the turn in which it was taken up, what was asked."""
        found: dict[int, list[Setup]] = defaultdict(list)
        for told in self.told:
            if told.setup.query:
                found[told.header.stamp].append(told.setup)
        return found


@dataclass(frozen=True)
class Recorded:
    """What a recording has of one service.

    Attributes:
        service: its name.
        lives: its starts, in their order.
        payloads: by key and check sum, what others said.
        ahead: from a stamp of the service to its arrival in the recording, at the least [ns].
        present: times [ns] and sessions at which others were first heard, and their names.
        about: what is said of the recording.
    """

    service: str
    lives: Sequence[Life]
    payloads: dict[tuple[str, int], bytes]
    ahead: int
    present: Sequence[tuple[int, int, str]]
    about: Mapping[str, Mapping[str, Any]]

    def unheard(self) -> Iterator[tuple[str, int]]:
        """Key and check sum of each message that the service took and the recording did not hear."""
        for life in self.lives:
            for _, entry, key in life.entries():
                if key and (key, entry.mark) not in self.payloads:
                    yield key, entry.mark


def outputs(service: str) -> list[Topic]:
    """The topics of a service's answers."""
    return [topic for topic in TOPICS if publisher_named(service) in topic.publishers]


def read(paths: Sequence[Path], service: str) -> Recorded:
    """What is recorded of a service.

    Args:
        paths: the recording's files in their order.
        service: its name.

    Raises:
        NoRecording: a file is none, or it does not say what the service took.
        OSError: a file cannot be read.
    """
    # Pictures are many, and concern nobody else.
    keys = {topic.key for topic in TOPICS if service == "task" or topic is not SENSOR_CAMERA}
    keys |= {setup_topic(name).key for name in HEALTHY}
    about: dict[str, Mapping[str, Any]] = {}
    lives: dict[int, Life] = {}
    payloads: dict[tuple[str, int], bytes] = {}
    said: list[tuple[Heard, Said]] = []
    present: dict[int, tuple[int, str]] = {}
    own, answered = setup_topic(service).key, {topic.key for topic in outputs(service)}
    ahead: list[int] = []
    for path in paths:
        log = Log(path, keys)
        for one in log:
            told = _told(one)
            if told is None:
                payloads[one.key, mark_of(one.payload)] = one.payload
                if one.key in answered and (answer := _said(one)) is not None:
                    said.append((one, answer))
                continue
            # It was there since the first thing that it tells of.
            first = next(entries(told.setup.diary), None)
            since = one.arrival_ns - (told.header.stamp - first.time if first else 0)
            present.setdefault(told.header.session, (since, one.key.partition("/")[2]))
            if one.key == own:
                lives.setdefault(told.header.session, Life(told.header.session)).told.append(told)
                ahead.append(one.arrival_ns - told.header.stamp)
        about |= log.about
    if not ahead:
        raise NoRecording(
            f"{paths[0]}: nothing under {own}: what {service} took is not known, so it cannot be replayed"
        )
    for one, answer in said:
        if (life := lives.get(answer.header.session)) is not None:
            life.answers.setdefault(one.key, {})[answer.header.stamp] = answer
    for life in lives.values():
        life.told.sort(key=lambda told: told.header.seq)
        life.lost = sum(_missing(answers) for answers in life.answers.values())
    there = [(since - min(ahead), session, name) for session, (since, name) in present.items()]
    return Recorded(
        service, sorted(lives.values(), key=lambda life: life.known_until), payloads, min(ahead), there, about
    )


def said_by(one: Heard, sessions: Collection[int]) -> bool:
    """Whether one of these sessions said it."""
    said = _said(one)
    return said is not None and said.header.session in sessions


def _told(one: Heard) -> Told | None:
    if not one.key.startswith("setup/"):
        return None
    topic = topic_by_key(one.key)
    assert topic is not None
    try:
        return Told(*decode(topic.message, one.payload, topic.cap))
    except Rejected:
        return None


def _said(one: Heard) -> Said | None:
    topic = topic_by_key(one.key)
    assert topic is not None
    try:
        return Said(decode(topic.message, one.payload, topic.cap)[0], one.payload)
    except Rejected:
        return None


def _missing(answers: Mapping[int, Said]) -> int:
    numbers = [said.header.seq for said in answers.values()]
    return max(numbers) - min(numbers) + 1 - len(numbers)
