"""How the robot follows the person who guides it: movement by movement, how far, how late.

Everything is held against what the person wants (`sim/world.hand.wanted`). Held against each other, the two ends of one
rigid panel would say nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from services.experiment.carry.carry_protocol import Guidance
from services.experiment.carry.motion import Motion
from services.experiment.measure.series import rate

WISHING = {"move": 0.005, "turn": 0.01}  # [m/s, rad/s]: a wish that moves no faster stands
SHORTEST = {"along": 0.02, "across": 0.02, "roll": 0.1}  # [m, rad]: less is no movement of the script
BREAK = 0.4  # [s] of standing that divide two movements; the person pauses for 1 s
SETTLING = 1.0  # [s] after a movement in which the robot may still be catching up
PUSH = 1.0  # [N] by which the hands' force has changed when the person is felt to push: the base's dead band
BUDGE = 0.002  # [m] by which the tool has moved when the robot is seen to move
BEFORE = (0.8, 0.3)  # [s] before a movement: the hands' force then is what it was at rest


@dataclass(frozen=True)
class Followed:
    """One movement; NaN where it did not take place.

    Attributes:
        name, way: of the movement, as in the script.
        start, end: when the person began to want it and when that wish stood again [s].
        wanted: how far the person wanted to get [m, rad], signed.
        far, near, base: how far the far end with the hands, the robot's end and the base went, as shares of that.
        lag, base_lag: how much later than the wish robot's end and base were half-way [s]; infinite if they never were.
        reaction: time [s] from the push that the hands feel to the tool's motion.

    Of a turn, what concerns the base and the reaction is NaN.
    """

    name: str
    way: str
    start: float
    end: float
    wanted: float
    far: float
    near: float
    base: float
    lag: float
    base_lag: float
    reaction: float

    def short(self, share: float) -> float:
        """How much [m, rad] a share of the way falls short of it, or goes beyond."""
        return abs(1.0 - share) * abs(self.wanted)


@dataclass(frozen=True)
class Ways:
    """How far wish, far end, robot's end and base are (n,) [m, rad] from where a movement began, in its direction.

    Attributes:
        push: force (n,) [N] of the hands that way; NaN of a turn, as is `base`.
    """

    wish: np.ndarray
    far: np.ndarray
    near: np.ndarray
    base: np.ndarray
    push: np.ndarray

    @classmethod
    def of(cls, motion: Motion, way: str, begin: int) -> Ways:
        """Along a way ("along", "across" or "roll") since an instant."""
        if way == "roll":
            none = np.full(len(motion.time), np.nan)
            wish, far, near = (values - values[begin] for values in (motion.wish_roll, motion.roll, motion.tool_roll))
            return cls(wish, far, near, none, none)
        x, y = motion.panel_axes[begin, :2, 0] / np.linalg.norm(motion.panel_axes[begin, :2, 0])
        direction = np.array((x, y) if way == "along" else (-y, x))
        wish, far, near, base = (
            (path[:, :2] - path[begin, :2]) @ direction for path in (motion.wish, motion.hand, motion.tool, motion.base)
        )
        return cls(wish, far, near, base, motion.push[:, :2] @ direction)


def followed(motion: Motion, script: Sequence[Guidance]) -> tuple[Followed, ...]:
    """What became of each movement of a script, in its order."""
    left = sorted((*_movements(motion, "move"), *_movements(motion, "turn")))
    found = []
    for guidance in script:
        fits = next((span for span in left if _fits(motion, span, guidance)), None)
        if fits is None:
            found.append(_missing(guidance))
            continue
        following = left.index(fits) + 1
        until = left[following][0] if following < len(left) else len(motion.time) - 1
        left = left[following:]
        found.append(_one(motion, guidance, *fits, until))
    return tuple(found)


def _movements(motion: Motion, doing: str) -> list[tuple[int, int, str]]:
    """Begin, end (indices) and way of everything that the person wanted while about one thing."""
    about = motion.doing == doing
    if not about.any():
        return []
    ways = ("roll",) if doing == "turn" else ("along", "across")
    wish = motion.wish_roll[:, None] if doing == "turn" else motion.wish[:, :2]
    moving = np.flatnonzero(about & (np.linalg.norm(rate(motion.time, wish), axis=1) > WISHING[doing]))
    if not len(moving):
        return []
    gaps = np.flatnonzero(np.diff(motion.time[moving]) > BREAK)
    spans = zip(moving[np.r_[0, gaps + 1]], moving[np.r_[gaps, len(moving) - 1]], strict=True)
    found = []
    for begin, end in spans:
        gone = {way: abs(Ways.of(motion, way, begin).wish[end]) for way in ways}
        way = max(ways, key=lambda name: gone[name])
        if gone[way] > SHORTEST[way]:
            found.append((int(begin), int(end), way))
    return found


def _fits(motion: Motion, span: tuple[int, int, str], guidance: Guidance) -> bool:
    begin, end, way = span
    return way == guidance.way and Ways.of(motion, way, begin).wish[end] * guidance.amount > 0.0


def _missing(guidance: Guidance) -> Followed:
    nan = float("nan")
    base = nan if guidance.way == "roll" else 0.0
    return Followed(guidance.name, guidance.way, nan, nan, guidance.amount, 0.0, 0.0, base, nan, nan, nan)


def _one(motion: Motion, guidance: Guidance, begin: int, end: int, way: str, until: int) -> Followed:
    time = motion.time
    last = min(int(np.searchsorted(time, time[end] + SETTLING)), until)
    gone, sense, turned, nan = (Ways.of(motion, way, begin), np.sign(guidance.amount), way == "roll", float("nan"))
    span = slice(begin, last + 1)

    def half_way(values: np.ndarray) -> float:
        """When [s] half of the way was behind it; of what it went, if it did not go all of it."""
        gone = sense * values[span]
        return float(time[span][np.argmax(gone >= 0.5 * gone[-1])]) if gone[-1] > 0.0 else float("inf")

    return Followed(
        name=guidance.name,
        way=way,
        start=float(time[begin]),
        end=float(time[end]),
        wanted=guidance.amount,
        far=float(gone.far[last] / guidance.amount),
        near=float(gone.near[last] / guidance.amount),
        base=float(gone.base[last] / guidance.amount),
        lag=half_way(gone.near) - half_way(gone.wish),
        base_lag=nan if turned else half_way(gone.base) - half_way(gone.wish),
        reaction=nan if turned else _reaction(time, begin, last, sense * gone.near, sense * gone.push),
    )


def _reaction(time: np.ndarray, begin: int, last: int, near: np.ndarray, push: np.ndarray) -> float:
    """From the push to the motion [s]; infinite if there was none."""
    first, rest = np.searchsorted(time, time[begin] - np.array(BEFORE))
    pushed = np.flatnonzero(push[rest:last] - np.median(push[first:rest]) > PUSH)
    if not len(pushed):
        return float("nan")
    felt = rest + int(pushed[0])
    moved = np.flatnonzero(near[felt:last] - near[felt] > BUDGE)
    return float(time[felt + moved[0]] - time[felt]) if len(moved) else float("inf")
