"""What became of one draw."""

from __future__ import annotations

from dataclasses import dataclass

TOLERANCE = 1.05  # [1] times the stated bound: what is beyond it is false


@dataclass(frozen=True)
class Verdict:
    """One sensor or camera, judged.

    Attributes:
        kind: of the draw.
        seed: that draws it again.
        sound: whether it keeps everything that is declared of it.
        refused: the words with which it was refused; empty if it was accepted.
        false: what was stated and what was true; empty if nothing false was.
        outside: the same where nothing in the data contradicts what a person declared, and why that is so.
    """

    kind: str
    seed: int
    sound: bool
    refused: str = ""
    false: str = ""
    outside: str = ""
