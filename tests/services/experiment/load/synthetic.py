"""Recordings of the load experiment made from a one-dimensional model of arm, bag and ground, good or with a defect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.experiment.load import load_protocol as protocol
from services.experiment.play.course import Run
from services.experiment.play.recording import Event, Recording
from shared.spatial import GRAVITY

STEP = 0.01  # [s]
ERROR_BOUND = 0.4  # [N]
MAX_LINEAR = 0.25  # [m/s]
ROPE = 0.62  # [m] from the tool to the bag's bottom
GROUND_STIFFNESS = 2000.0  # [N/m]


@dataclass(frozen=True)
class Defect:
    """What goes wrong in the recorded run; the defaults are a good one."""

    sag_under_light: float = 0.0  # [m]
    holds_heavy: bool = False
    bounces: float = 0.0  # [m] amplitude on the way down
    stays_low: float = 0.0  # [m] missing at the end
    keeps_pressing: float = 0.0  # [N] over the limit with the bag on the ground
    swings: float = 0.0  # [N] amplitude of the load on the way down
    stall: float = 0.0  # [s] during which no sample came
    braked_at: float = 0.0  # [s] after which the load swings by 10 N for 0.4 s, as after a brake
    told_brake: bool = True  # the robot counts it
    force_x: float = 0.0  # [N] sideways while the light bag hangs


def recording(run: Run, defect: Defect | None = None, seed: int = 0) -> Recording:
    """One run of 45 s at 100 Hz with noise within the error bound."""
    defect = defect or Defect()
    rng = np.random.default_rng(seed)
    time = np.arange(-2.0, protocol.END_AT, STEP)
    height, force, bag, weights = (np.zeros(len(time)) for _ in range(4))
    z, velocity = protocol.HOLD[2], 0.0
    for k, now in enumerate(time):
        weight = _weight(now)
        hang = z - ROPE
        ground = max(0.0, min(weight, -GROUND_STIFFNESS * hang)) if weight else 0.0
        load = weight - ground
        velocity = _velocity(run, defect, load, z, velocity)
        z += velocity * STEP
        offset = defect.bounces * np.sin(6.0 * now) if weight == protocol.HEAVY and hang > 0.02 else 0.0
        height[k] = z + offset - (defect.stays_low if now > protocol.UNLOAD_AT else 0.0)
        height[k] -= defect.sag_under_light if weight == protocol.LIGHT else 0.0
        if defect.keeps_pressing and weight == protocol.HEAVY and ground:
            load = protocol.FORCE_LIMIT[2] + defect.keeps_pressing
        if weight == protocol.HEAVY and not ground:
            load += defect.swings * np.sin(20.0 * now)
            load += 10.0 * np.sin(30.0 * now) if 0.0 <= now - defect.braked_at < 0.4 else 0.0
        force[k], bag[k], weights[k] = -load, max(hang, 0.0), weight
    return _assemble(run, defect, time, height, force, bag, weights, rng)


def _weight(now: float) -> float:
    if now >= protocol.UNLOAD_AT or now < protocol.LIGHT_AT:
        return 0.0
    return protocol.LIGHT if now < protocol.HEAVY_AT else protocol.HEAVY


def _velocity(run: Run, defect: Defect, load: float, z: float, last: float) -> float:
    """A caricature of the laws: towards the pose at 0.5/s, downwards beyond the limit."""
    wanted = 0.5 * (protocol.HOLD[2] - z)
    if run.law == "stiffness":
        wanted = 2.0 * (protocol.HOLD[2] - z - load / 40.0)
    elif load > protocol.FORCE_LIMIT[2] and not defect.holds_heavy:
        wanted = -0.15
    elif load >= protocol.FORCE_LIMIT[2] - 0.5:
        wanted = 0.0
    elif load > 0:
        wanted = min(wanted, 0.3 * (protocol.FORCE_LIMIT[2] - load) / protocol.FORCE_LIMIT[2])
    wanted = float(np.clip(wanted, -MAX_LINEAR, MAX_LINEAR))
    return last + float(np.clip(wanted - last, -0.02, 0.02))


def _assemble(
    run: Run,
    defect: Defect,
    time: np.ndarray,
    height: np.ndarray,
    force: np.ndarray,
    bag: np.ndarray,
    weights: np.ndarray,
    rng: np.random.Generator,
) -> Recording:
    count = len(time)
    forces = rng.uniform(-0.25, 0.25, (count, 3))
    forces[:, 2] += force
    forces[:, 0] += np.where(weights == protocol.LIGHT, defect.force_x, 0.0)
    position = np.tile(np.array(protocol.HOLD[:3]), (count, 1))
    position[:, 2] = height
    hanging = weights > 0
    topics = {
        "state/ee": {"time": time, "position": position + rng.normal(0, 2e-5, (count, 3))},
        "wrench/external": {
            "time": time,
            "force": forces,
            "torque": rng.normal(0, 0.01, (count, 3)),
            "error_bound": np.full((count, 6), ERROR_BOUND),
        },
        "sensor/ft": {"time": time[(time < 12.0) | (time > 12.0 + defect.stall)]},
        "control/status": {
            "time": time,
            "state": np.where((time > 12.0) & (time < 12.0 + defect.stall), "braking", "tracking"),
            "reason": np.where((time > 12.0) & (time < 12.0 + defect.stall), "sensor/ft is silent", ""),
        },
        "sim/world": {
            "time": time,
            "bag.mass": np.where(hanging, weights / GRAVITY, np.nan),
            "bag.height": np.where(hanging, bag, np.nan),
        },
        "state/robot": {
            "time": time[::10],
            "max_linear": np.full(len(time[::10]), MAX_LINEAR),
            "held": ((time[::10] >= defect.braked_at) & (defect.braked_at > 0.0) & defect.told_brake).astype(
                int
            ),
        },
        "state/joints": {
            "time": time,
            "name": np.array([["torso_lift_joint", "arm_right_1_joint"]]),
            "position": np.stack([height - 0.8, np.zeros(count)], axis=1),
        },
    }
    events = [
        Event(protocol.LIGHT_AT, "light", f"{protocol.LIGHT:g} N"),
        Event(protocol.HEAVY_AT, "heavy", f"{protocol.HEAVY:g} N"),
        Event(protocol.UNLOAD_AT, "unload", "taken off"),
    ]
    meta = {
        "experiment": "load",
        "name": run.name,
        "force_limit": list(protocol.FORCE_LIMIT),
        "torque_limit": list(protocol.TORQUE_LIMIT),
        "settings": run.settings,
        "date": "2026-01-01 12:00",
    }
    return Recording(meta, events, topics)
