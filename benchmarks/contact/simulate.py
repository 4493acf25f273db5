"""Runs one control law through one case and measures it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.contact.adversary import CLEVER, Adversary
from benchmarks.contact.cases import Case
from benchmarks.contact.laws import CaseLaw
from benchmarks.contact.robot import Path, Robot
from benchmarks.contact.world import World
from shared.spatial import Array

# A sub-step changes the wrench by at most this share of the smallest limit, while the law keeps its own promise. Laws
# that do not may move faster: the sub-steps are never shorter than 1/100 period, and the peak is then far over anyway.
_CHANGE = 0.05
_LONGEST_STEP = 2e-3
# A swing of the wrench smaller than this share of the limit is no oscillation, nor is turning around less often.
_SWING = 0.1
_TURNS = 4


@dataclass(frozen=True)
class Trace:
    """A run over time: times (n,) [s], wrench less nominal over limit (n, 6), tool position (n, 3) [m]."""

    times: Array
    ratio: Array
    position: Array


@dataclass(frozen=True)
class Result:
    """What one run gave.

    Attributes:
        peak: largest abs(wrench - nominal)/limit at any instant.
        axis: the axis of the peak, 0 to 5.
        time: of the peak [s].
        travelled: path length of the tool origin [m].
        turned: path length of its rotation [rad].
        offset: position less target at the end (3,) [m].
        swing: back-and-forth of the wrench in the first and second half of the quiet end, in limits per second.
        turns: how often the wrench turns around in the second half, by more than a tenth of a limit each time.
        within_reach: whether no loaded contact left the declared reach.
        within_squeeze: whether the forces of all contacts together stayed within the limits, axis by axis.
        trace: the whole run, where it was asked for.
    """

    peak: float
    axis: int
    time: float
    travelled: float
    turned: float
    offset: tuple[float, float, float]
    swing: tuple[float, float]
    turns: int
    within_reach: bool
    within_squeeze: bool
    trace: Trace | None = None

    @property
    def covered(self) -> bool:
        """Whether every assumption of the proof about the contacts held."""
        return self.within_reach and self.within_squeeze

    @property
    def missing(self) -> float:
        """Distance from the target at the end [m]."""
        return math.hypot(*self.offset)

    @property
    def sustained(self) -> bool:
        """Whether it still oscillates at the end, and has not calmed down by a fifth meanwhile."""
        first, second = self.swing
        return self.turns >= _TURNS and second > 0.8 * first


def simulate(law: CaseLaw, keep_trace: bool = False) -> Result:
    """Runs a law through its case."""
    case = law.case
    rng = np.random.default_rng(case.seed)
    timing = case.timing
    robot = Robot(case.position.copy(), case.rotation.copy(), timing.lag)
    world = World(case.contacts, robot.position, robot.rotation)
    adversary = Adversary(case.adversary, case.error_bound, case.limit, rng, case.error)
    reach = float(np.linalg.norm(case.declared.contact_reach))

    start = case.moved(np.zeros(1))
    times, wrenches = [np.zeros(1)], [world.advance(robot.position[None], robot.rotation[None], start)]
    positions = [robot.position[None]]
    now, previous = 0.0, 0.0
    while now < case.duration:
        seen = _sample(times, wrenches, now - timing.latency)
        if now < case.quiet:
            tangent = _tangent(case, world, robot, now) if case.adversary in CLEVER else None
            error = adversary.error(seen - case.nominal, tangent)
        else:
            error = adversary.hold()
        dt = now - previous if now > 0.0 else timing.period
        twist = law.twist(seen + error, robot, now, dt)
        robot.command(now + rng.uniform(*timing.delay), twist, timing.declared_period)
        following = now + timing.period * (1.0 + rng.uniform(-timing.jitter, timing.jitter))
        path = robot.advance(now, following, _step(case, reach, robot.fastest, timing.period))
        times.append(path.times)
        wrenches.append(world.advance(path.positions, path.rotations, case.moved(path.times)))
        positions.append(path.positions)
        previous, now = now, following
    whole = Path(np.concatenate(times), np.concatenate(positions), np.empty((0, 3, 3)))
    return _measure(case, whole, np.concatenate(wrenches), robot, world, keep_trace)


def _tangent(case: Case, world: World, robot: Robot, now: float) -> Array:
    return world.stiffness(robot.position, robot.rotation, case.moved(np.array((now,)))[0])


def _sample(times: list[Array], wrenches: list[Array], time: float) -> Array:
    """The wrench (6,) at the first instant not before ``time``, so that it is never older than the latency."""
    newest = wrenches[-1][-1]
    for stretch, values in zip(reversed(times), reversed(wrenches), strict=True):
        index = int(np.searchsorted(stretch, time - 1e-12))
        if index < len(stretch):
            newest = values[index]
        if index > 0:
            break
    return newest


def _step(case: Case, reach: float, fastest: Array, period: float) -> float:
    """Longest sub-step [s] for the fastest translation and rotation (2,) [m/s, rad/s] on the way."""
    rate = case.declared.contact_stiffness * (fastest[0] + fastest[1] * reach)
    room = min(case.limit[:3].min(), case.limit[3:].min() / max(reach, 1e-3))
    wanted = _CHANGE * room / max(rate, 1e-9)
    return min(_LONGEST_STEP, max(wanted, period / 100.0))


def _measure(case: Case, path: Path, wrenches: Array, robot: Robot, world: World, keep: bool) -> Result:
    ratio = (wrenches - case.nominal) / case.limit
    row, axis = np.unravel_index(int(np.argmax(np.abs(ratio))), ratio.shape)
    middle = (case.quiet + case.duration) / 2.0
    settled = case.quiet + (middle - case.quiet) / 3.0
    target = case.target(case.duration)
    allowed = np.array(case.declared.contact_reach) + 1e-9
    return Result(
        peak=float(np.abs(ratio[row, axis])),
        axis=int(axis),
        time=float(path.times[row]),
        travelled=float(robot.travelled[0]),
        turned=float(robot.travelled[1]),
        offset=tuple((robot.position - target.position).tolist()),
        swing=(_swing(path.times, ratio, settled, middle), _swing(path.times, ratio, middle, case.duration)),
        turns=max(_turning_points(column) for column in ratio[path.times >= middle].T),
        within_reach=bool(np.all(world.reach <= allowed)),
        within_squeeze=bool(np.all(world.squeeze <= case.limit[:3] + np.abs(case.nominal[:3]) + 1e-9)),
        trace=Trace(path.times, ratio, path.positions) if keep else None,
    )


def _swing(times: Array, ratio: Array, start: float, end: float) -> float:
    """Total variation less net change of the worst axis, per second."""
    part = ratio[(times >= start) & (times <= end)]
    if len(part) < 2:
        return 0.0
    variation = np.abs(np.diff(part, axis=0)).sum(axis=0) - np.abs(part[-1] - part[0])
    return float(variation.max() / (end - start))


def _turning_points(values: Array) -> int:
    """How often ``values`` (n,) turn around by more than ``_SWING``."""
    count, direction = 0, 0
    low = high = float(values[0])
    for value in values.tolist():
        low, high = min(low, value), max(high, value)
        if direction <= 0 and value > low + _SWING:
            count, direction, high = count + (direction < 0), 1, value
        elif direction >= 0 and value < high - _SWING:
            count, direction, low = count + (direction > 0), -1, value
    return count
