"""Whether the tool moves as commanded, and what is measured moves along: a centimetre, a few degrees, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from services.cli.check.bench import Bench
from services.cli.check.heard import Commander
from services.cli.check.rows import Row, judged
from shared.messages import BaseTwistCommand, TwistCommand
from shared.spatial import Array, rotation_matrix, rotation_vector
from shared.topics import COMMAND_BASE_TWIST, STATE_BASE, STATE_EE

SPEED, WAY = 0.02, 0.01
"""[m/s], [m] of each motion along an axis."""
TURN, ANGLE = 0.1, 0.05
"""[rad/s], [rad] of each motion about an axis."""
TTL = 0.1  # [s] of each command
BEAT = 100  # commands after which a swaying tool turns round
PATIENCE = 2.0
"""[s] A motion takes half a second. A robot that moves without telling of it goes four centimetres until then."""
RESTS_WITHIN = 1.0  # [s] after a motion
ASIDE = 0.2  # [1] share of a motion that may go another way
STRAY, STRAY_TURN = 0.004, 0.02
"""[m], [rad] of the tool's origin when it turns, and of its orientation when it moves."""
SPEEDS = 0.6, 1.5
"""[1] Least and greatest share of the commanded speed that has to be told on the way."""
NOT_ALONG = 0.01  # [rad] between the turn of the tool and that of its sensor
_AXES = "xyz"
_ZERO = np.zeros(3)


def along_z(speed: float, ttl: float = TTL) -> TwistCommand:
    """A command to go up at a speed [m/s]."""
    return TwistCommand(np.array((0.0, 0.0, speed)), np.zeros(3), ttl)


def swaying() -> Callable[[], TwistCommand]:
    """Commands up and down, so that the tool stays near."""
    count = iter(range(10**9))
    return lambda: along_z(SPEED * (1 if next(count) // (BEAT // 2) % 2 else -1))


def tool_moves(bench: Bench, commander: Commander) -> Iterator[Row]:
    """A row for each axis, along and about: forth and back."""
    for axis, name in enumerate(_AXES):
        for what, turning in ((f"tool along {name}", False), (f"tool about {name}", True)):
            wrong = ""
            for sign in (1.0, -1.0):
                wrong = wrong or _motion(bench, commander, axis, sign, turning)
            done = f"{ANGLE:g} rad" if turning else f"{1e3 * WAY:g} mm"
            yield judged(what, wrong, f"{done} forth and back as commanded, and the sensor along")


def _motion(bench: Bench, commander: Commander, axis: int, sign: float, turning: bool) -> str:
    """Move a short way; what was wrong with it, or ""."""
    robot = bench.robot
    start, before = robot.tool.position, robot.rotation
    sensor = rotation_matrix(robot.sample.orientation)
    velocity, way = (TURN, ANGLE) if turning else (SPEED, WAY)
    wanted = np.zeros(3)
    wanted[axis] = sign * velocity
    command = TwistCommand(_ZERO, wanted, TTL) if turning else TwistCommand(wanted, _ZERO, TTL)
    seen = robot.all(STATE_EE)[-1].header.seq

    def moved() -> tuple[Array, Array]:
        return robot.tool.position - start, rotation_vector(robot.rotation @ before.T)

    def far() -> bool:
        # Whichever way it goes: who moves otherwise than commanded is not let move on.
        return float(np.linalg.norm(moved()[turning])) > way

    commander.make = lambda: command
    arrived = bench.within(PATIENCE, far)
    commander.make = lambda: None
    rested = bench.within(RESTS_WITHIN, robot.at_rest)
    along, other = moved()[turning], moved()[not turning]
    if not arrived and np.linalg.norm(along) < 0.1 * way:
        reason = robot.status.reason or "nothing"
        return f"the tool did not move within {PATIENCE:g} s; state/robot says: {reason}"
    if not rested:
        return f"the tool still moves {RESTS_WITHIN:g} s after the last command; it acts for {TTL:g} s"
    unit = "rad" if turning else "m"
    told = f"{_told(along)} {unit} for a command of {_told(wanted)} {unit}/s"
    aside = float(np.linalg.norm(np.delete(along, axis)))
    if sign * along[axis] < 0.5 * way or aside > ASIDE * float(np.linalg.norm(along)):
        return f"moved by {told}: axes or signs of command or pose are wrong; all are those of base"
    if np.linalg.norm(other) > (STRAY if turning else STRAY_TURN):
        stray = f"{_told(other)} {'m' if turning else 'rad'}"
        return f"moved by {told}, and its {'origin' if turning else 'orientation'} by {stray}: is the tool frame right?"
    with_sensor = rotation_vector(rotation_matrix(robot.sample.orientation) @ sensor.T)
    turned = rotation_vector(robot.rotation @ before.T)
    if np.linalg.norm(with_sensor - turned) > NOT_ALONG:
        return f"the tool turned by {_told(turned)} rad and its sensor by {_told(with_sensor)}: sensor/ft orientation"
    name = "angular" if turning else "linear"
    speeds = [getattr(one.message, name)[axis] * sign for one in robot.all(STATE_EE) if one.header.seq > seen]
    # Of the samples on the way: single ones may be off where speeds are made of positions.
    told_speed = float(np.median([speed for speed in speeds if speed > 0.3 * velocity] or [0.0]))
    if not SPEEDS[0] * velocity < told_speed < SPEEDS[1] * velocity:
        return f"state/ee told {name} {sign * told_speed:.3g} {unit}/s on the way, commanded was {sign * velocity:g}"
    return ""


def base_moves(bench: Bench, commander: Commander) -> Iterator[Row]:
    """A row for each way that the base can go: forth and back."""
    ways = [
        ("base along x", 0),
        *([("base along y", 1)] if bench.robot.status.base_type == "omni" else []),
        ("base turns", 2),
    ]
    for what, axis in ways:
        wrong = ""
        for sign in (1.0, -1.0):
            wrong = wrong or _base_motion(bench, commander, axis, sign)
        done = f"{ANGLE:g} rad" if axis == 2 else f"{1e3 * WAY:g} mm"
        yield judged(what, wrong, f"{done} or more forth and back as commanded")


def _base_motion(bench: Bench, commander: Commander, axis: int, sign: float) -> str:
    robot, start = bench.robot, bench.robot.base
    velocity = np.zeros(3)
    velocity[axis] = sign * (TURN if axis == 2 else SPEED)
    way = ANGLE if axis == 2 else WAY

    def moved() -> Array:
        """In base axes at the start."""
        now = robot.base
        x, y = now.position - start.position
        cosine, sine = np.cos(start.yaw), np.sin(start.yaw)
        turned = np.remainder(now.yaw - start.yaw + np.pi, 2.0 * np.pi) - np.pi
        return np.array((cosine * x + sine * y, cosine * y - sine * x, turned))

    commander.make = lambda: BaseTwistCommand(velocity, TTL)
    arrived = bench.within(PATIENCE, lambda: bool((np.abs(moved()) > (WAY, WAY, ANGLE)).any()))
    commander.make = lambda: None
    rested = bench.within(RESTS_WITHIN, robot.base_at_rest)
    if not arrived and abs(moved()[axis]) < 0.1 * way:
        return f"the base did not move within {PATIENCE:g} s; state/robot says: {robot.status.reason or 'nothing'}"
    if not rested:
        return f"the base still moves {RESTS_WITHIN:g} s after the last command; it acts for {TTL:g} s"
    shares = moved() / (WAY, WAY, ANGLE)
    if sign * shares[axis] < 0.5 or np.abs(np.delete(shares, axis)).max() > 2.0 * ASIDE * abs(shares[axis]):
        told = f"{_told(moved())} (m, m, rad) for a command of {_told(velocity)}"
        return f"{STATE_BASE.key} went on by {told}: axes or signs of {COMMAND_BASE_TWIST.key} or odometry are wrong"
    return ""


def _told(vector: Array) -> str:
    return "[" + ", ".join(f"{value + 0.0:.3f}" for value in vector) + "]"
