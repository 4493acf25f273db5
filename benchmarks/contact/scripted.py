"""Scripted cases: the counterexamples that broke simpler laws, the wall, and the approach in free space."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from benchmarks.contact.cases import Case, Declared, Target, Timing
from benchmarks.contact.elastic import Spring, Surface
from benchmarks.contact.world import Contact
from shared.spatial import Array, rotation_from_vector

_FORCE_LIMIT = np.repeat((25.0, 10.0), 3)
_CARRY_LIMIT = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))
_AT_REST = np.zeros(2), np.zeros((2, 3))
WALL_STIFFNESS = 2000.0
WALL_TRAVEL = {"slide": 0.2, "retreat": 0.15}
WALL_PRESS = 3.0


def timing(period: float, delay: float = 0.0, lag: float = 0.0) -> Timing:
    """Exactly periodic, with a constant delay, all declared as it is."""
    return Timing(period, 0.0, (delay, delay), 0.0, lag, period, delay, lag)


def declared(stiffness: float, reach: tuple[float, float, float], weight: float = 5.0) -> Declared:
    """Declared contacts without friction, and a robot that is limited by nothing but its speed."""
    return Declared(stiffness, reach, 0.0, weight, 0.25, 1.0, (1e3,) * 6)


def still(
    group: str, contacts: tuple[Contact, ...], limit: Array, targets: tuple[Target, ...], duration: float
) -> Case:
    """A case from the origin, environment at rest, without errors, at 100 Hz."""
    return Case(
        group=group,
        seed=0,
        position=np.zeros(3),
        rotation=np.eye(3),
        contacts=contacts,
        limit=limit,
        error_bound=np.zeros(6),
        nominal=np.zeros(6),
        timing=timing(0.01),
        declared=declared(1000.0, (0.05, 0.05, 0.05)),
        adversary="none",
        targets=targets,
        shift_times=_AT_REST[0],
        shift=_AT_REST[1],
        quiet=duration - 1.2,
        duration=duration,
    )


def oblique_spring(number: int) -> Case:
    """One spring at 45 degrees whose stiffnesses differ by 10 or 50, with errors that make yielding on x push y up.

    Number runs over 40 targets, two ratios, and three adversaries: 240 cases; the error bound is 1.5 N in every second
    one, and 0.3 N in the others, where less is kept in reserve.
    """
    angle = 2.0 * math.pi * (number % 40) / 40.0
    ratio = (0.1, 0.02)[number // 40 % 2]
    adversary = ("constant", "potential", "axis")[number // 80 % 3]
    stiff, soft = np.array((1.0, 1.0, 0.0)) / math.sqrt(2.0), np.array((-1.0, 1.0, 0.0)) / math.sqrt(2.0)
    matrix = 1000.0 * (np.outer(stiff, stiff) + ratio * np.outer(soft, soft))
    target = np.array((math.cos(angle), math.sin(angle), 0.0)) * 0.3
    case = still(
        "oblique spring",
        (Contact(np.zeros(3), True, Spring(matrix, np.zeros(3))),),
        np.array((10.0, 10.0, 10.0, 3.0, 3.0, 3.0)),
        (Target(0.0, target, np.eye(3)),),
        3.0,
    )
    error = np.repeat((1.5 if number % 2 else 0.3, 0.0), 3)
    return replace(
        case, error_bound=error, adversary=adversary, error=error * (1.0, -1.0, 1.0, 1.0, 1.0, 1.0), seed=number
    )


def turning_face(number: int) -> Case:
    """The tool's face (1, 1, 1) is pressed on a fixed point close to its limits, then the tool turns."""
    rng = np.random.default_rng(number)
    normal = np.ones(3) / math.sqrt(3.0)
    turn = rng.normal(size=3)
    turn *= rng.uniform(0.2, 0.8) / np.linalg.norm(turn)
    pressed = 0.25 * normal
    case = still(
        "turning face",
        (Contact(np.zeros(3), False, Surface(normal, np.zeros(3), 100.0)),),
        np.array((10.0, 10.0, 10.0, 10.0, 10.0, 10.0)),
        (Target(0.0, pressed, np.eye(3)), Target(2.5, pressed, rotation_from_vector(turn))),
        6.0,
    )
    return replace(case, declared=declared(100.0, (0.3, 0.3, 0.3), weight=20.0))


_PULLED_AT = (
    (_FORCE_LIMIT, np.zeros(3), np.array((1.0, 0.0, 0.0))),
    (_CARRY_LIMIT, np.array((0.0, 0.8, 0.0)), np.array((0.0, 0.0, 1.0))),
    (_CARRY_LIMIT, np.array((0.6, 0.3, 0.05)), np.array((0.25, -0.43, 0.87))),
)
_PULL_TIMINGS = ((1.0 / 30.0, 0.03, 0.0), (0.01, 0.02, 0.02), (0.004, 0.03, 0.0))


def steady_pull(number: int) -> Case:
    """A spring in every direction, as stiff as declared or softer, that is pulled steadily for 1.5 s and then held.

    Number runs over three timings, declared exactly, three places (the tool itself, a lever across the axis with the
    smallest limit, an oblique one), 500 and 2000 N/m, all of it, a half or a fifth really there, 0.1 and 0.2 m/s: 108
    cases. As stiff as declared, at the lever and with nothing to spare in time, is the hardest for stability.
    """
    number, speed = number // 2, (0.1, 0.2)[number % 2]
    number, share = number // 3, (1.0, 0.5, 0.2)[number % 3]
    number, stiffness = number // 2, (500.0, 2000.0)[number % 2]
    limit, arm, direction = _PULLED_AT[number % 3]
    way = speed * 1.5 * direction
    spring = Contact(arm, True, Spring(share * stiffness * np.eye(3), arm))
    case = still("steady pull", (spring,), limit, (Target(0.0, np.zeros(3), np.eye(3)),), 3.2)
    x, y, z = (np.abs(arm) + 0.01).tolist()
    return replace(
        case,
        timing=timing(*_PULL_TIMINGS[number // 3 % 3]),
        declared=declared(stiffness, (x, y, z), weight=1.0),
        shift_times=np.array((0.0, 0.2, 1.7, case.quiet)),
        shift=np.stack((np.zeros(3), np.zeros(3), way, way)),
    )


def wall(action: str, declared_stiffness: float) -> Case:
    """Presses a frictionless wall of 2000 N/m for 3 s, then slides along it or retreats, within 6 s."""
    into = np.array((0.1, 0.0, 0.0))
    after = (
        np.array((0.1, WALL_TRAVEL["slide"], 0.0)) if action == "slide" else np.array((-WALL_TRAVEL["retreat"], 0, 0))
    )
    surface = Surface(np.array((-1.0, 0.0, 0.0)), np.array((0.005, 0.0, 0.0)), WALL_STIFFNESS)
    case = still(
        f"wall, {action}",
        (Contact(np.zeros(3), True, surface),),
        _FORCE_LIMIT,
        (Target(0.0, into, np.eye(3)), Target(WALL_PRESS, after, np.eye(3))),
        WALL_PRESS + 6.0,
    )
    return replace(
        case,
        error_bound=np.repeat((0.3, 0.03), 3),
        adversary="random",
        declared=declared(declared_stiffness, (0.05, 0.05, 0.05)),
    )


APPROACHES: dict[str, tuple[float, tuple[float, float, float], Array]] = {
    "person on a panel": (500.0, (1.05, 0.3, 0.05), _CARRY_LIMIT),
    "tool only, hard": (1e4, (0.1, 0.1, 0.1), _FORCE_LIMIT),
}


def approach(name: str, period: float, axis: int) -> Case:
    """Moves along one axis (0 to 5) in free space towards a target that is far away."""
    stiffness, reach, limit = APPROACHES[name]
    position, turn = np.zeros(3), np.zeros(3)
    (position if axis < 3 else turn)[axis % 3] = 2.0
    case = still(f"approach, {name}", (), limit, (Target(0.0, position, rotation_from_vector(turn)),), 1.5)
    return replace(
        case,
        error_bound=np.repeat((0.3, 0.03), 3),
        timing=timing(period, delay=0.01),
        declared=declared(stiffness, reach, weight=50.0),
    )
