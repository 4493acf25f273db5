"""How the robot follows the person who guides it: movement by movement, how far, how late."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from services.experiment.carry.motion import Motion, rate
from services.experiment.carry.protocol import Guidance

MOVING = {"along": 0.02, "across": 0.02, "roll": 0.05}  # [m/s, rad/s]: slower counts as standing
SHORTEST = {"along": 0.02, "across": 0.02, "roll": 0.1}  # [m, rad]: less is no movement of the script
BREAK = 0.4  # [s] of standing that divide two movements; the person pauses for 1 s
SETTLING = 1.0  # [s] after a movement in which the robot may still be catching up
PUSH = 1.0  # [N] by which the hands' force has changed when the person is felt to push: the base's dead band
BUDGE = 0.002  # [m] by which the tool has moved when the robot is seen to move
BEFORE = (0.8, 0.3)  # [s] before a movement shows: the hands' force then is what it was at rest


@dataclass(frozen=True)
class Followed:
    """One movement; NaN where it did not take place.

    Attributes:
        name: of the movement.
        start, end: when the hands began to move and when they stood again [s].
        wanted: how far the person wanted to get [m, rad], signed.
        far: the share of it that the far end, with the hands, went.
        near: how far the robot's end went, as a share of the far end's way.
        base: how far the base went along, as a share of it; of a turn, NaN.
        lag: how much later the tool was half-way than the hands [s].
        reaction: time [s] from the push that the hands feel to the tool's motion; of a turn, NaN.
    """

    name: str
    start: float
    end: float
    wanted: float
    far: float
    near: float
    base: float
    lag: float
    reaction: float


def followed(motion: Motion, script: Sequence[Guidance]) -> tuple[Followed, ...]:
    """What became of each movement of a script, in its order."""
    left = sorted((*_movements(motion, "move"), *_movements(motion, "turn")))
    found = []
    for guidance in script:
        fits = next((span for span in left if _fits(motion, span, guidance)), None)
        if fits is None:
            nan = float("nan")
            found.append(Followed(guidance.name, nan, nan, guidance.amount, 0.0, 0.0, 0.0, nan, nan))
            continue
        following = left.index(fits) + 1
        until = left[following][0] if following < len(left) else len(motion.time) - 1
        left = left[following:]
        found.append(_one(motion, guidance, *fits, until))
    return tuple(found)


def _movements(motion: Motion, doing: str) -> list[tuple[int, int, str]]:
    """Begin, end (indices) and way of everything that the hands did while the person was about one thing."""
    about = motion.doing == doing
    if not about.any():
        return []
    ways: tuple[str, ...]
    if doing == "turn":
        speed, ways = np.abs(rate(motion.time, motion.roll[:, None])[:, 0]), ("roll",)
    else:
        speed, ways = np.linalg.norm(rate(motion.time, motion.hand[:, :2]), axis=1), ("along", "across")
    moving = np.flatnonzero(about & (speed > MOVING[ways[0]]))
    if not len(moving):
        return []
    gaps = np.flatnonzero(np.diff(motion.time[moving]) > BREAK)
    spans = zip(moving[np.r_[0, gaps + 1]], moving[np.r_[gaps, len(moving) - 1]], strict=True)
    found = []
    for begin, end in spans:
        gone = {way: abs(_coordinate(motion, way, begin)[0][end]) for way in ways}
        way = max(ways, key=lambda name: gone[name])
        if gone[way] > SHORTEST[way]:
            found.append((int(begin), int(end), way))
    return found


def _fits(motion: Motion, span: tuple[int, int, str], guidance: Guidance) -> bool:
    begin, end, way = span
    return way == guidance.way and _coordinate(motion, way, begin)[0][end] * guidance.amount > 0.0


def _coordinate(
    motion: Motion, way: str, begin: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Hands, tool and base (n,) [m, rad] since an instant, along a way, and the hands' force (n,) [N] along it."""
    if way == "roll":
        far, near = motion.roll, motion.tool_roll
        return far - far[begin], near - near[begin], np.full(len(far), np.nan), np.full(len(far), np.nan)
    x, y = motion.panel_axes[begin, :2, 0] / np.linalg.norm(motion.panel_axes[begin, :2, 0])
    direction = np.array((x, y) if way == "along" else (-y, x))
    far, near, base = (values[:, :2] @ direction for values in (motion.hand, motion.tool, motion.base))
    return far - far[begin], near - near[begin], base - base[begin], motion.push[:, :2] @ direction


def _one(motion: Motion, guidance: Guidance, begin: int, end: int, way: str, until: int) -> Followed:
    time = motion.time
    last = min(int(np.searchsorted(time, time[end] + SETTLING)), until)
    sense = np.sign(guidance.amount)
    far, near, base, push = (sense * values for values in _coordinate(motion, way, begin))
    span = slice(begin, last + 1)
    return Followed(
        name=guidance.name,
        start=float(time[begin]),
        end=float(time[end]),
        wanted=guidance.amount,
        far=float(far[last] / abs(guidance.amount)),
        near=float(near[last] / far[last]),
        base=float(base[last] / far[last]),
        lag=_half_way(time[span], near[span]) - _half_way(time[span], far[span]),
        reaction=float("nan") if way == "roll" else _reaction(time, begin, last, near, push),
    )


def _half_way(time: np.ndarray, way: np.ndarray) -> float:
    return float(time[np.argmax(way >= 0.5 * way[-1])])


def _reaction(time: np.ndarray, begin: int, last: int, near: np.ndarray, push: np.ndarray) -> float:
    """From the push to the motion [s]; infinite if there was none."""
    first, rest = np.searchsorted(time, time[begin] - np.array(BEFORE))
    pushed = np.flatnonzero(push[rest:last] - np.median(push[first:rest]) > PUSH)
    if not len(pushed):
        return float("nan")
    felt = rest + int(pushed[0])
    moved = np.flatnonzero(near[felt:last] - near[felt] > BUDGE)
    return float(time[felt + moved[0]] - time[felt]) if len(moved) else float("inf")
