"""What the person of a carry does, and how: fast or slow, far or near, and what goes wrong."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

Phase = dict[str, Any]


@dataclass(frozen=True)
class Habit:
    """How a person who is harder to carry with goes about a movement; by default as smoothly as any.

    Attributes:
        pieces: that a movement falls into; the person rests between them.
        quickness: speed of each piece, of what it would be [1].
        pause: between two pieces [s].
        overshoot: share of a movement that the person goes too far, and comes back.
    """

    pieces: int = 1
    quickness: float = 1.0
    pause: float = 1.0
    overshoot: float = 0.0

    @classmethod
    def drawn(cls, draw: np.random.Generator, kind: str) -> Habit:
        """A habit that suits a kind of case."""
        match kind:
            case "jerks":
                return cls(int(draw.integers(4, 9)), draw.uniform(3.0, 6.0), draw.uniform(0.1, 0.4))
            case "hesitates":
                return cls(int(draw.integers(2, 5)), pause=draw.uniform(0.5, 2.0))
            case "corrects":
                return cls(pause=draw.uniform(0.0, 0.3), overshoot=draw.uniform(0.1, 0.3))
            case "hurries":
                return cls(quickness=draw.uniform(3.0, 5.0))
        return cls()

    def moves(self, phase: Phase, name: str) -> Iterator[Phase]:
        """A movement by ``phase[name]`` the way the person makes it."""
        quick = phase | {"speed": min(FASTEST, self.quickness * phase["speed"])}
        shares = [1.0 / self.pieces] * self.pieces
        if self.overshoot:
            shares = [1.0 + self.overshoot, -self.overshoot]
        for number, share in enumerate(shares, 1):
            part = {name: (share * np.array(phase[name])).tolist()}
            yield quick | part | ({"pause": self.pause} if number < len(shares) else {})


FASTEST = 1.0
"""[m/s, rad/s] On average; a script allows no more."""


@dataclass(frozen=True)
class Manner:
    """How the person carries.

    Attributes:
        pace: speeds, of the built-in script's [1].
        lift: height [m].
        forwards, back, aside: ways [m]; ``aside`` is to the left, there and back.
        twist: [degrees], there and back.
        drops: whether the person lets go of the far end in the middle.
        waits: whether the person lets go of the panel on the ground only after the robot did.
        habit: of moving.
    """

    pace: float
    lift: float
    forwards: float
    back: float
    aside: float
    twist: float
    drops: bool
    waits: bool
    habit: Habit = field(default_factory=Habit)

    @classmethod
    def drawn(cls, draw: np.random.Generator, arm_only: bool, kind: str) -> Manner:
        """A manner that suits a kind of case; without a base the person stays where the arm reaches."""
        far = 0.15 if arm_only else 1.0
        return cls(
            pace=float(draw.uniform(0.6, 1.5)),
            lift=float(draw.uniform(0.10, 0.20)),
            forwards=far * float(draw.uniform(0.3, 0.6)),
            back=-far * float(draw.uniform(0.2, 0.4)),
            aside=(0.5 if arm_only else 1.0) * float(draw.choice((-1.0, 1.0)) * draw.uniform(0.2, 0.4)),
            twist=float(draw.choice((-1.0, 1.0)) * draw.uniform(10.0, 20.0)),
            drops=kind == "drops his end",
            waits=kind != "lets go first",
        )


def script(manner: Manner) -> str:
    """The TOML text that `sim/command hand` takes."""
    return "\n".join(
        "\n".join(("[[phase]]", *(f"{name} = {json.dumps(value)}" for name, value in phase.items())))
        for phase in _phases(manner)
    )


def _phases(manner: Manner) -> Iterator[Phase]:
    pace, moves = manner.pace, manner.habit.moves
    linear, angular = 0.1 * pace, 0.2 * pace
    yield {"do": "wait", "until": "grasp", "patience": 600}
    yield {"do": "take_hold"}
    yield {"do": "lift", "height": manner.lift, "speed": 0.05 * pace}
    for way in ([manner.forwards, 0.0, 0.0], [manner.back, 0.0, 0.0]):
        yield from moves({"do": "move", "by": way, "speed": linear}, "by")
    if manner.drops:
        yield {"do": "let_go"}
        return
    for aside in (manner.aside, -manner.aside):
        yield from moves({"do": "move", "by": [0.0, aside, 0.0], "speed": linear}, "by")
    for angle in (manner.twist, -manner.twist):
        yield from moves({"do": "turn", "about": "x", "angle": angle, "speed": angular}, "angle")
    moves = replace(manner.habit, overshoot=0.0).moves  # to the panel's edge, which anybody can see
    yield from moves({"do": "turn", "about": "x", "angle": 90, "speed": angular, "patience": 30}, "angle")
    yield {"do": "lower", "speed": 0.08 * pace, "patience": 60}
    if manner.waits:
        yield {"do": "wait", "until": "release", "patience": 120}
    yield {"do": "let_go"}
