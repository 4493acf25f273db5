"""What a film is made of: a recording, and what happens in it in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Part:
    """Something that takes place from ``start`` to ``end`` [s].

    Attributes:
        name: of it, for figures.
        caption: what a film says meanwhile.
        still: what a still of its end is called; empty if there is to be none.
    """

    name: str
    start: float
    end: float
    caption: str = ""
    still: str = ""


@dataclass(frozen=True)
class Take:
    """A recording to film.

    Attributes:
        path: of it.
        title: of the run.
        zero: time [s] of the recorder's clock from which the film and its parts count.
        parts: in order of time.
    """

    path: Path
    title: str
    zero: float
    parts: Sequence[Part]
