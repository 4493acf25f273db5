"""Whether readings contradict what was declared: if none does, nobody could have found out by them."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.honest.sensor import DOWN, TOOL_OFFSET, Sensor
from services.wrench.compensation import gravity_in_sensor
from services.wrench.wrench import ATTITUDE
from shared.spatial import GRAVITY, Array, skew

_MASSES = np.linspace(0.0, 1.0, 201)  # [1] of the largest declared one


def possible(how: str, readings: list[tuple[Array, Array]], sensor: Sensor, declared: Any) -> bool:
    """Whether some sensor and some tool, both as declared, give the readings of a calibration with nothing touching.

    Args:
        how: "tare" or "identify".
        readings: each (6,) with the sensor in base (3, 3); one attitude is one pose.
        sensor: for the noise of its averages.
        declared: the wrench service's parameters.
    """
    poses: dict[bytes, list[Array]] = {}
    rotations: dict[bytes, Array] = {}
    for raw, rotation in readings:
        poses.setdefault(rotation.tobytes(), []).append(raw)
        rotations[rotation.tobytes()] = rotation
    means = np.array([np.mean(part, axis=0) for part in poses.values()])
    error = 5.0 * sensor.sigma / np.sqrt(min(map(len, poses.values()))) + 0.5 * sensor.step
    slope = declared.floor_tilt + ATTITUDE
    if how == "identify":
        return identification_possible(means, error, list(rotations.values()), declared, slope)
    return tare_possible(means[0], error, next(iter(rotations.values())), declared, slope)


def tare_possible(mean: Array, error: Array, rotation: Array, declared: Any, slope: float) -> bool:
    """Whether some tool and some bias, both as declared, give this average at rest.

    For each mass m the force leaves a bias, and so does the torque but for where the centre may be.

    Args:
        mean: average (6,) [N, Nm], sensor axes.
        error: bound (6,) on its error.
        rotation: sensor in base (3, 3).
        declared: the wrench service's parameters.
        slope: largest error [rad] of gravity's direction that is declared.
    """
    field = gravity_in_sensor(rotation)
    aside = declared.tool_reach * np.sqrt(np.maximum(0.0, GRAVITY**2 - field**2))
    arm = float(np.linalg.norm(TOOL_OFFSET)) + declared.tool_reach
    leaning = slope * GRAVITY * np.repeat((1.0, arm), 3)
    for mass in declared.tool_mass * _MASSES:
        weight = mass * np.concatenate((field, np.cross(TOOL_OFFSET, field)))
        room = np.array(declared.bias_bound) + error + mass * (np.concatenate((np.zeros(3), aside)) + leaning)
        if (np.abs(mean - weight) <= room).all():
            return True
    return False


def identification_possible(means: Array, error: Array, rotations: list[Array], declared: Any, slope: float) -> bool:
    """Whether some tool and some bias, both as declared, give these averages at rest.

    Args:
        means: averages (n, 6).
        error: bound (6,) on the error of each.
        rotations: sensor in base (3, 3) of each.
        declared: the wrench service's parameters.
        slope: largest error [rad] of gravity's direction that is declared.
    """
    down = [rotation.T @ DOWN for rotation in rotations]
    forces = np.vstack([np.column_stack((axis, np.eye(3))) for axis in down])
    torques = np.vstack([np.column_stack((-skew(axis), np.eye(3))) for axis in down])
    found, left = [], []
    for rows, part in ((forces, means[:, :3]), (torques, means[:, 3:])):
        solution = np.linalg.lstsq(rows, part.ravel(), rcond=None)[0]
        found.append(solution)
        left.append((part.ravel() - rows @ solution).reshape(part.shape))
    weight, bias = found[0][0], np.concatenate((found[0][1:], found[1][3:]))
    leaning = slope * abs(weight) * np.array((1.0, 1.0, 1.0, 0.2, 0.2, 0.2))
    allowed = error + leaning
    explained = (np.abs(np.hstack(left)) <= allowed).all()
    heavy = declared.tool_mass * GRAVITY + allowed[0] * 2.0
    return bool(
        explained and 0.0 < weight < heavy and (np.abs(bias) <= np.array(declared.bias_bound) + 2 * allowed).all()
    )
