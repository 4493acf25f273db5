"""All draws: which there are, and how each is played again."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.honest import camera_kinds, camera_trial, sensor_faults, sensor_kinds, sensor_trial
from benchmarks.honest.verdict import Verdict

SENSORS = {**sensor_kinds.KINDS, **sensor_faults.KINDS}
KINDS = {**SENSORS, **camera_kinds.KINDS}
CAMERAS = 0.25
"""Share of the draws that are cameras: each takes as long as thirty sensors."""


@dataclass(frozen=True)
class Draw:
    """One sensor or camera, the same each time."""

    seed: int
    kind: str
    number: int

    def play(self, **service: Any) -> Verdict:
        """What becomes of it; ``service`` takes the place of the real one."""
        random = np.random.default_rng((self.seed, zlib.crc32(self.kind.encode()), self.number))
        case: Any = KINDS[self.kind][1](random)
        play: Any = camera_trial.play if self.kind in camera_kinds.KINDS else sensor_trial.play
        return play(self.kind, self.number, case, random, **service)


def plan(seed: int, draws: int) -> list[Draw]:
    """About so many draws, at least one of each kind, in a fixed mixed order."""
    planned = []
    for kinds, share in ((SENSORS, 1.0 - CAMERAS), (camera_kinds.KINDS, CAMERAS)):
        weights: float = sum(weight for weight, _ in kinds.values())
        for kind, (weight, _) in kinds.items():
            count = max(1, round(draws * share * weight / weights))
            planned += [Draw(seed, kind, number) for number in range(count)]
    return sorted(planned, key=lambda draw: zlib.crc32(f"{draw.kind}:{draw.number}".encode()))


def play_all(draws: list[Draw], processes: int) -> Iterator[Verdict]:
    """All verdicts, in the order of the draws."""
    if processes <= 1:
        yield from map(Draw.play, draws)
        return
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(Draw.play, draws, chunksize=4)
