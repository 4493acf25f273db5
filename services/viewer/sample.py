"""What the functions that draw are given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

from shared.schema.records import Record
from shared.topics import Topic

M = TypeVar("M", bound=Record)
N = TypeVar("N", bound=Record)


class Sample(NamedTuple, Generic[M]):
    """A message, and when it arrived [s] since the beginning."""

    time: float
    message: M


class Newest:
    """The newest messages of other topics.

    Args:
        known: by key, the message and its age [s].
    """

    def __init__(self, known: Callable[[str], tuple[Record, float] | None]) -> None:
        self._known = known

    def __call__(self, topic: Topic[N]) -> N | None:
        """The newest message of a topic; None if there is none that may be used."""
        told = self._known(topic.key)
        return told[0] if told is not None and told[1] <= topic.max_age else None  # type: ignore[return-value]
