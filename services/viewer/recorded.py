"""Recordings drawn from their beginning to their end into any stream, as a viewer that was there would have."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import rerun as rr

from services.viewer.draw.drawing import PERIOD, Drawing
from services.viewer.draw.why import note
from services.viewer.heard import Ears
from services.viewer.stream import below
from shared.clock import nanoseconds, seconds
from shared.wire.log import Log

CURVES_EVERY = 5.0
"""Time [s] that a piece of a curve is long: nobody waits for it, and a browser takes in few large ones far faster."""
GAP = 3.0
"""Time [s] that is shown between two runs: all that was heard in the first one is old by then."""


class RecordedClock:
    """A clock that whoever reads moves on."""

    def __init__(self) -> None:
        self.now = 0

    def now_ns(self) -> int:
        """Time [ns] since the beginning of what is read."""
        return self.now


def draw(
    rec: rr.RecordingStream,
    runs: Sequence[Sequence[Path]],
    goes_on: Callable[[float], bool] = lambda time: True,
    side: str = "",
) -> float:
    """Draw recordings, one after the other on one time axis.

    Args:
        rec: to draw into.
        runs: the recordings, each by its files in their order.
        goes_on: asked now and then, with the time up to which is drawn [s], whether to go on.
        side: path below which all of it is drawn, beside what else is in the stream.

    Returns:
        How long they last [s].

    Raises:
        NoRecording: one is none.
        OSError: one cannot be read.
    """
    clock = RecordedClock()
    ears = Ears(clock, 0)
    rec = below(rec, side)
    drawing = Drawing(rec, ears, CURVES_EVERY, side)
    due = period = nanoseconds(PERIOD)
    for heard_ns, key, payload in _on_one_axis(rec, runs):
        # Threads of a bus note what they hear side by side: a clock never goes back.
        heard_ns = max(heard_ns, clock.now)
        while heard_ns > due:
            clock.now = max(due, clock.now)
            drawing.advance()
            due += period
            if not goes_on(ears.now):
                return ears.now
        clock.now = heard_ns
        ears.hear(key, payload)
    drawing.end()
    return ears.now


def _on_one_axis(rec: rr.RecordingStream, runs: Sequence[Sequence[Path]]) -> Iterator[tuple[int, str, bytes]]:
    """Time [ns] on the axis, key and payload of all that was heard, with a note where each recording begins."""
    end = -nanoseconds(GAP)
    for paths in runs:
        shift: int | None = None
        for key, arrival_ns, payload in (heard for path in paths for heard in Log(path)):
            if shift is None:
                # Whoever recorded another one had another clock.
                shift = end + nanoseconds(GAP) - arrival_ns
                note(rec, f"{paths[0].parent.name}/{paths[0].name} begins", seconds(arrival_ns + shift))
            end = arrival_ns + shift
            yield end, key, payload
