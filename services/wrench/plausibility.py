"""Whether the zero or the payload that was measured is possible: by what is declared, and by the zero before.

An average r of a free tool at rest is bias plus weight. With g gravity and o the tool's origin in sensor axes, there
has to be a mass m in [0, tool_mass] so that in every direction u (the axes, and gravity's own)

    |u . (r_f   - m g)|     <= sum_i |u_i| bias_bound_i + m t |g|
    |u . (r_tau - m o x g)| <= sum_i |u_i| bias_bound_i + m (tool_reach |u x g| + t |g| (|o| + tool_reach))

with t the largest error of gravity's direction [rad]. All of it is convex in m. What a touch makes of r within these
limits cannot be told from a bias, unless there is a former zero: that nothing touches the tool is the person's word.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from services.wrench.averaging import AXES, SIGMAS, UNITS, Average
from services.wrench.compensation import Compensation, payload_wrench, weight_of_up
from services.wrench.identification import IdentifiedPayload
from shared.parameters import Refused
from shared.spatial import GRAVITY, Array, cross

_FORCE, _TORQUE = slice(0, 3), slice(3, 6)
LIGHTEST = 0.5  # share of `tool_mass` that the tool weighs at least, if there is one
_SHORTEST = 60.0  # [s] between two zeros whose difference says how fast the sensor drifts


@dataclass(frozen=True)
class Declared:
    """What the person said of sensor and tool.

    Attributes:
        bias_bound: (6,) [N, Nm], sensor axes.
        tool_mass: largest mass [kg] beyond the sensor.
        tool_reach: largest distance [m] of its centre from the tool's origin.
        tool_offset: tool's origin from the sensor's origin (3,) [m], sensor axes.
        tilt: largest error of gravity's direction [rad].
    """

    bias_bound: Array
    tool_mass: float
    tool_reach: float
    tool_offset: Array
    tilt: float

    @property
    def lever(self) -> Array:
        """Length per axis (6,) [1, m] by which an unknown weight may act: 1 for forces, its largest arm for torques."""
        return np.repeat((1.0, float(np.linalg.norm(self.tool_offset)) + self.tool_reach), 3)


@dataclass(frozen=True)
class Former:
    """A zero of this run of the robot process: with what, bound (6,) [N, Nm] on its error by now, age [s]."""

    compensation: Compensation
    error: Array
    age: float


def refusal(doubt: str) -> Refused:
    """A refusal because of a doubt, with the way out."""
    return Refused(f"{doubt} `force` adopts it all the same")


def tare_doubt(average: Average, known: Compensation, declared: Declared, former: Former | None) -> str:
    """Why the average of a tare cannot be that of a free tool, with the likely causes in order; empty if it can.

    Args:
        average: of the tool at rest; its rotation in upright axes.
        known: compensation in force, of which an identified payload counts.
        declared: by the person.
        former: zero of this run, None without one.
    """
    up, error = average.rotation[2], average.mean_error
    left = _left(average.mean, error, up, known, declared)
    if left.max() <= 0.0:
        return _moved(average.mean, error, up, declared, former)
    axis = int(np.argmax(left / (declared.bias_bound + error)))
    causes = "Does something touch the tool, or hang from it? Is another tool mounted than is known?"
    if _left(-average.mean, error, up, known, declared).max() <= 0.0:
        causes = f"Are the readings of the opposite sign (wanted is what the environment exerts on the robot)? {causes}"
    known_weight = (
        f"{known.mass:.3g} kg identified" if known.kind == "payload" else f"tool_mass {declared.tool_mass:g} kg"
    )
    return (
        f"{AXES[axis]} reads {average.mean[axis]:.3g} {UNITS[axis]}, of which the tool ({known_weight}) and a bias "
        f"within bias_bound leave {left[axis]:.3g} {UNITS[axis]} unexplained. {causes} Is bias_bound or tool_mass "
        "declared too small?"
    )


def payload_doubt(result: IdentifiedPayload, declared: Declared, former: Former | None) -> str:
    """Why a payload that explains its poses is not possible, with the likely causes in order; empty if it is.

    Args:
        result: of the identification.
        declared: by the person.
        former: zero of this run, None without one.
    """
    found = result.compensation()
    arm = float(np.linalg.norm(result.com))
    if result.mass * (1.0 - declared.tilt) - found.mass_error > declared.tool_mass:
        return (
            f"{result.mass:.3f} kg were found, tool_mass declares {declared.tool_mass:g} kg at most. Does something "
            "hang from the tool or pull it down? Is tool_mass declared too small? Is the unit N, and the gain right?"
        )
    slack = SIGMAS * float(np.linalg.norm(result.sigma_com)) + declared.tilt * arm + declared.tool_reach
    away = float(np.linalg.norm(result.com - declared.tool_offset))
    if away > slack:
        mirrored = float(np.linalg.norm(result.com + declared.tool_offset)) <= slack
        return (
            f"the centre of mass found lies {away:.3f} m from the tool's origin, tool_reach declares "
            f"{declared.tool_reach:g} m at most. {'Are the torques of the opposite sign? ' if mirrored else ''}Is the "
            "torques' unit Nm, and about the sensor's origin? Are tool_offset and tool_reach right?"
        )
    slope = GRAVITY * result.mass * declared.tilt * np.repeat((1.0, arm), 3)
    error = found.bias_error + found.misfit_peak + slope
    room = declared.bias_bound + error
    axis = int(np.argmax(np.abs(found.bias) - room))
    if abs(found.bias[axis]) > room[axis]:
        return (
            f"a bias of {found.bias[axis]:.3g} {UNITS[axis]} was found in {AXES[axis]}, bias_bound declares "
            f"{declared.bias_bound[axis]:g} {UNITS[axis]}. Is it declared too small for this sensor? Does a cable or "
            "somebody pull on the tool, turning with it?"
        )
    if former is None:
        return ""
    up = former.compensation.up if former.compensation.kind == "tare" else -former.compensation.down
    error = error + GRAVITY * np.repeat((found.mass_error, found.moment_error), 3)
    return _moved(_reading(found, up), error, up, declared, former)


def forced(adopted: Compensation, doubt: str, declared: Declared, former: Former | None = None) -> Compensation:
    """What is adopted in spite of a doubt: declared bounds that it refutes do not count any more. As it is without one.

    By one attitude bias and weight cannot be told apart: each alone has to explain a tare.
    """
    if not doubt:
        return adopted
    bias_bound = np.maximum(np.maximum(declared.bias_bound, adopted.bias_bound), np.abs(adopted.bias))
    heavy = -float(adopted.bias[:3] @ adopted.up) / GRAVITY
    drift = adopted.drift
    if former is not None and former.age >= _SHORTEST and former.compensation.kind == adopted.kind:
        change = np.abs(adopted.bias - former.compensation.bias) - adopted.bias_error - former.compensation.bias_error
        if np.all(change <= declared.bias_bound):  # farther than that no zero drifts
            drift = np.maximum(drift, change * 60.0 / former.age)
    return adopted.replaced(warning=doubt, bias_bound=bias_bound, tool_mass=max(0.0, heavy), drift=drift)


def _reading(known: Compensation, up: Array) -> Array:
    """What a free tool reads (6,) at an attitude, by a compensation; a tare's weight is that of its own attitude."""
    return known.bias + weight_of_up(known) @ up if known.kind == "payload" else known.bias


def _left(reading: Array, error: Array, up: Array, known: Compensation, declared: Declared) -> Array:
    """What (6,) the likeliest mass leaves unexplained of a reading, by axis; all are 0 or less if it is possible."""
    gravity = -GRAVITY * up
    directions = np.vstack((np.eye(3), up))
    bound = declared.bias_bound + error
    if known.kind == "payload":
        tilted = GRAVITY * np.repeat((known.mass, float(np.linalg.norm(known.moment))), 3) * declared.tilt
        wrong = GRAVITY * np.repeat((known.mass_error, known.moment_error), 3)
        bound = bound + known.misfit(up) + tilted + wrong
        low = high = 0.0
        reading = reading - weight_of_up(known) @ up
    else:
        low, high = 0.0, declared.tool_mass
    across = np.sqrt(np.maximum(0.0, GRAVITY**2 - (directions @ gravity) ** 2))
    slope = GRAVITY * declared.tilt * declared.lever[[0, 3]]
    value = np.concatenate([directions @ reading[part] for part in (_FORCE, _TORQUE)])
    room = np.concatenate([np.abs(directions) @ bound[part] for part in (_FORCE, _TORQUE)])
    weight = payload_wrench(1.0, declared.tool_offset, np.vstack((np.zeros((2, 3)), up)))
    per_mass = np.concatenate([directions @ weight[part] for part in (_FORCE, _TORQUE)])
    room_per_mass = np.concatenate((np.full(4, slope[0]), declared.tool_reach * across + slope[1]))

    def left(mass: float) -> Array:
        return np.abs(value - mass * per_mass) - room - mass * room_per_mass

    while high - low > 1e-6:
        third = (high - low) / 3.0
        if (left(low + third) / room).max() <= (left(high - third) / room).max():
            high -= third
        else:
            low += third
    # What is left along gravity is told with the axis that is closest to it.
    found = left(high)
    near = int(np.argmax(np.abs(up)))
    found[near], found[4 + near] = max(found[near], found[3]), max(found[4 + near], found[7])
    return np.delete(found, (3, 7))


def _moved(reading: Array, error: Array, up: Array, declared: Declared, former: Former | None) -> str:
    """Why the former zero contradicts what a free tool reads now at an attitude; empty if it does not."""
    if former is None:
        return ""
    before = former.compensation
    room = former.error + error
    if before.kind == "payload":
        room = room + before.misfit(up) + GRAVITY * np.repeat((before.mass_error, before.moment_error), 3)
        room = room + 2.0 * GRAVITY * before.mass * declared.tilt * declared.lever
    else:
        turned = GRAVITY * (up - before.up)
        across = np.sqrt(np.maximum(0.0, turned @ turned - turned**2))
        arm = np.abs(cross(declared.tool_offset, turned)) + declared.tool_reach * across
        room = room + declared.tool_mass * np.concatenate((np.abs(turned), arm))
        if turned @ turned > 1e-3:
            room = room + 2.0 * GRAVITY * declared.tool_mass * declared.tilt * declared.lever
    change = np.abs(reading - _reading(before, up))
    axis = int(np.argmax(change / room))
    if change[axis] <= room[axis]:
        return ""
    return (
        f"{AXES[axis]} differs by {change[axis]:.3g} {UNITS[axis]} from the zero of {former.age:.0f} s ago, of which "
        f"noise, weight and drift explain {room[axis]:.3g}. Does something touch the tool now, or did it then? Is it "
        "another tool? Does the sensor drift faster than zero_drift?"
    )


@lru_cache(maxsize=4)
def lightest(mass: float, reach: float, *offset: float) -> Compensation:
    """The tool with the least weight and the shortest lever that are taken for one, by what is declared of it."""
    far = math.hypot(*offset)
    lever = LIGHTEST * mass * (max(0.0, 1.0 - reach / far) if far > 0.0 else 0.0)
    return Compensation("payload", mass=LIGHTEST * mass, moment=lever * np.array(offset))
