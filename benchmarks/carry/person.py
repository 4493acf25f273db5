"""What the person of a carry does, and how: fast or slow, far or near, and what goes wrong."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np


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
    """

    pace: float
    lift: float
    forwards: float
    back: float
    aside: float
    twist: float
    drops: bool
    waits: bool

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


def _phases(manner: Manner) -> Iterator[dict[str, Any]]:
    pace = manner.pace
    linear, angular = 0.1 * pace, 0.2 * pace
    yield {"do": "wait", "until": "grasp", "patience": 600}
    yield {"do": "take_hold"}
    yield {"do": "lift", "height": manner.lift, "speed": 0.05 * pace}
    for way in ([manner.forwards, 0.0, 0.0], [manner.back, 0.0, 0.0]):
        yield {"do": "move", "by": way, "speed": linear}
    if manner.drops:
        yield {"do": "let_go"}
        return
    for aside in (manner.aside, -manner.aside):
        yield {"do": "move", "by": [0.0, aside, 0.0], "speed": linear}
    for angle in (manner.twist, -manner.twist):
        yield {"do": "turn", "about": "x", "angle": angle, "speed": angular}
    yield {"do": "turn", "about": "x", "angle": 90, "speed": angular, "patience": 30}
    yield {"do": "lower", "speed": 0.08 * pace, "patience": 60}
    if manner.waits:
        yield {"do": "wait", "until": "release", "patience": 120}
    yield {"do": "let_go"}
