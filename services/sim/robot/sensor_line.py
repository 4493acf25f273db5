"""Faults that can be put on a sensor on purpose, to see what everybody else makes of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeVar

import numpy as np

from shared.spatial import Array


class Sent(Protocol):
    """A message on its way, a dataclass."""

    @property
    def late(self) -> float:
        """Age [s] of its content."""
        ...

    @property
    def payload(self) -> bytes | None:
        """What is sent in its place, if anything is."""
        ...


T = TypeVar("T")
S = TypeVar("S", bound=Sent)

GARBAGE = bytes(range(256))
"""A payload that is no MessagePack map."""


class SensorLine:
    """One sensor with its connection, and what is wrong with it.

    The sensor's values go through ``stick`` and ``shift``, its messages through ``send``.
    """

    def __init__(self) -> None:
        self.kind = "ok"
        self._value: Array = np.zeros(1)
        self._stuck: object = None
        self._time = 0.0
        self._queue: deque[tuple[float, Any]] = deque()

    def break_down(self, kind: str, value: Sequence[float]) -> None:
        """Put a fault on the line, or take it off with ``ok``.

        Args:
            kind: one of ``FAULTS`` in ``shared.sim_messages``.
            value: ``bias``: added to every axis, or one number per axis; ``delay``: one number [s]; else unused.
        """
        self.kind = kind
        self._value = np.array(value)
        self._stuck = None
        self._queue.clear()

    def stick(self, measure: Callable[[], T]) -> T:
        """The measured value, or, while stuck, the one measured first since then."""
        if self.kind != "stuck":
            return measure()
        if self._stuck is None:
            self._stuck = measure()
        return self._stuck  # type: ignore[return-value]

    def shift(self, value: Array) -> Array:
        """A value (n,) with the bias of this fault, if it has one."""
        return value + self._value if self.kind == "bias" else value

    def send(self, outputs: list[S], dt: float) -> list[S]:
        """What becomes of a tick's messages, ``dt`` [s] after the last tick."""
        self._time += dt
        if self.kind == "off":
            return []
        if self.kind == "garbage":
            return [_changed(output, payload=GARBAGE) for output in outputs]
        if self.kind != "delay":
            return outputs
        delay = float(self._value[0])
        self._queue.extend((self._time + delay, _changed(output, late=output.late + delay)) for output in outputs)
        arrived = []
        while self._queue and self._queue[0][0] <= self._time + 1e-9:
            arrived.append(self._queue.popleft()[1])
        return arrived


def _changed(output: S, **values: Any) -> S:
    return replace(output, **values)  # type: ignore[type-var]
