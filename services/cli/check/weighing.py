"""Signs and frames of the wrist's sensor, by a known weight that hangs from the tool."""

from __future__ import annotations

import numpy as np

from services.cli.check.bench import Bench
from services.cli.check.heard import Robot
from services.cli.check.rows import Row
from shared.spatial import GRAVITY, Array, cross, rotation_matrix
from shared.topics import SENSOR_FT

AVERAGED = 100
"""Samples of which a reading is the mean."""
SETTLED = 30.0  # [s] at most until a weight hangs still
LEFT_ALONE = 1.5  # [s] after that
OFF = 0.15, 0.15
"""[1], [Nm per N] Share of the weight that the force may be off, and torque about the tool's origin per weight."""
AT_LEAST = 0.7  # [N] that the force may be off, however small the weight


def wrench_in_base(robot: Robot, samples: int = AVERAGED) -> tuple[Array, Array]:
    """Force [N] and torque [Nm] about the tool's origin, base axes, averaged over the newest samples."""
    forces, torques = [], []
    for heard in robot.all(SENSOR_FT)[-samples:]:
        sample = heard.message
        rotation = rotation_matrix(sample.orientation)  # type: ignore[attr-defined]
        forces.append(rotation @ sample.force)  # type: ignore[attr-defined]
        torques.append(rotation @ (sample.torque - cross(sample.tool_offset, sample.force)))  # type: ignore[attr-defined]
    return np.mean(forces, axis=0), np.mean(torques, axis=0)


def weighed(bench: Bench, before: tuple[Array, Array], mass: float, patience: float = SETTLED) -> Row:
    """Whether the sensor shows a mass [kg] that hangs from the tool's origin, compared with before."""
    weight = mass * GRAVITY
    wanted = np.array((0.0, 0.0, -weight))

    def change() -> tuple[Array, Array]:
        force, torque = wrench_in_base(bench.robot)
        return force - before[0], torque - before[1]

    def right() -> bool:
        force, torque = change()
        return bool(
            np.linalg.norm(force - wanted) < max(OFF[0] * weight, AT_LEAST)
            and np.linalg.norm(torque) < max(0.15, OFF[1] * weight * 0.1)
        )

    if good := bench.within(patience, right):
        # As soon as it is right it may still be on its way.
        bench.wait(LEFT_ALONE)
        good = right()
    force, torque = change()
    said = f"{mass:g} kg changes the force by {_vector(force)} N and the torque about the tool by {_vector(torque)} Nm"
    if good:
        return Row("weight", True, said)
    return Row(
        "weight", False, f"{said}; wanted {_vector(wanted)} N and none, base axes: {_reason(force, weight, torque)}"
    )


def _reason(force: Array, weight: float, torque: Array) -> str:
    """What a wrong reading looks like."""
    size = float(np.linalg.norm(force))
    if size < 0.3 * weight:
        return "the sensor does not see it. Does it hang from the tool? Is it the sensor of this arm?"
    if abs(size - weight) > 0.3 * weight:
        return "the size is wrong. Does the whole weight hang freely? Are force and torque in N and Nm?"
    if force[2] > 0.8 * size:
        return "the sign is wrong: the contract wants what the environment exerts on the robot"
    tilted = np.degrees(np.arccos(-force[2] / size))
    if tilted > 10.0:
        return f"it pulls {tilted:.0f} degrees away from down: the sensor's axes or orientation are not as told"
    return f"torque {_vector(torque)} Nm: tool_offset is wrong, or the weight hangs beside the tool's origin"


def _vector(values: Array) -> str:
    return "[" + ", ".join(f"{value + 0.0:.1f}" for value in values) + "]"
