"""Sensors that break what is declared of them: the readings, the axes, the calibration, the floor."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.honest.sensor import DOWN
from benchmarks.honest.sensor_kinds import BIAS_BOUND, NOISE_BOUND, Random, either, precise, resolved, sound
from benchmarks.honest.sensor_trial import Case, Trial
from shared.robot.tiago import SENSOR_RANGE
from shared.spatial import rotation_from_vector

QUIET = "a sensor that is declared to have no noise reads the same as a dead one, while the robot stands still"
NEVER = "an axis that has not moved yet is dead, or at rest and without noise: only a known weight tells"
SHOWS = np.array((1.5, 1.5, 1.5, 0.08, 0.08, 0.08))  # [N, Nm] of weight that cannot be missed
RARE = "one reading alone reads as a blow, until the next one is there"
LEANING = "the robot stands steeper than is declared, and does not say where down is: that reads as a touch"


def frozen(random: Random) -> Case:
    """Some axes, or all, keep their last value from some moment on."""
    sensor, how = sound(random), either(random)
    axes = range(6) if random.random() < 0.4 else random.choice(6, random.integers(1, 4), replace=False).tolist()
    quiet = random.random() < 0.3
    if quiet:
        sensor.sigma = np.zeros(6)

    def then(trial: Trial) -> None:
        trial.freeze(*axes)
        trial.run(random.uniform(0.0, 1.0))
        if quiet:
            trial.excuse = QUIET
            before = trial.weight
            trial.push(trial.some_push())
            trial.rotation = trial.turned(1.0)
            trial.run(0.3)
            # An identified weight that turns in the sensor's axes has to show; of a tared one nobody knows how much.
            shows = np.abs(trial.weight - before)[list(axes)] > SHOWS[list(axes)]
            trial.excuse = "" if how == "identify" and shows.any() else QUIET
            trial.run(0.3)
        trial.use()

    declared = resolved(sensor, np.full(6, 1e-3)) if quiet else {}
    return Case(sensor, declared, how, sound=False, then=then, excuse="")


def dead(random: Random) -> Case:
    """Some axes, or all, have not moved since the start."""
    sensor, how = sound(random), either(random)
    axes = range(6) if random.random() < 0.3 else random.choice(6, random.integers(1, 4), replace=False).tolist()
    sensor.frozen = tuple(axes)
    if random.random() < 0.5:
        sensor.bias[list(axes)] = 0.0
    return Case(sensor, how=how, sound=False, excuse=NEVER if how == "tare" else None)


def saturated(random: Random) -> Case:
    """Pushed beyond the range: told by the robot process, or not."""
    sensor = sound(random)
    sensor.tells = random.random() < 0.5
    sensor.limit = SENSOR_RANGE * random.choice((1.0, 1.0, 0.3))
    unknown = not sensor.tells and sensor.limit[0] < SENSOR_RANGE[0]

    def then(trial: Trial) -> None:
        for _ in range(3):
            push = trial.some_push(30.0, 1.5)
            push[:3] *= random.uniform(5.0, 20.0)
            trial.push(push, 0.5)

    # One that ends early without a word is known by its frozen axis, as soon as that may be told.
    return Case(sensor, how=either(random), sound=False, then=then, excuse="", lulls=unknown)


def spiking(random: Random) -> Case:
    sensor = sound(random)
    sensor.spike = NOISE_BOUND * random.choice((-1.0, 1.0), 6) * random.uniform(1.2, 20.0)
    often = random.random() < 0.6
    sensor.every = int(random.integers(8, 40)) if often else 217
    return Case(sensor, how=either(random), sound=False, excuse="" if often else RARE)


def touched(random: Random) -> Case:
    """Pushed sideways, loaded, turned while it is calibrated."""
    touch = np.concatenate((random.standard_normal(3), random.standard_normal(3)))
    force = (
        touch[:3] / np.linalg.norm(touch[:3]) * random.choice((2.0, 5.0, 15.0, 20.0, 40.0)) * random.uniform(0.5, 1.0)
    )
    if random.random() < 0.4:
        force = DOWN * np.linalg.norm(force)
    torque = touch[3:] / np.linalg.norm(touch[3:]) * random.choice((0.0, 0.5, 3.0, 8.0))
    sensor = sound(random)
    return Case(sensor, precise(sensor, random), either(random), sound=False, touch=np.concatenate((force, torque)))


def touched_again(random: Random) -> Case:
    """Tared well, and again a little later while something leans on the tool."""

    def then(trial: Trial) -> None:
        trial.run(2.0)
        # What it would read can hide in the declared bias, but not from the zero that is known already.
        trial.case = replace(trial.case, sound=False, excuse="")
        trial.calibrate("tare", trial.some_push(6.0, 0.0) + np.array((0.0, 0.0, -1.5, 0.0, 0.0, 0.0)))
        trial.use()

    sensor = sound(random)
    return Case(sensor, precise(sensor, random), then=then)


def turned(random: Random) -> Case:
    """Axes turned about the flange, swapped, mirrored, of the other sign, or those of base."""
    sensor = sound(random)
    which = random.choice(("about z", "any", "sign", "force sign", "swapped", "mirrored", "base", "little"))
    axes, signs = np.eye(3), np.eye(6)
    if which == "about z":
        axes = rotation_from_vector((0.0, 0.0, math.radians(random.choice((-90, -45, -20, 20, 45, 90, 120, 180)))))
    elif which in ("any", "little"):
        axis = random.standard_normal(3)
        angle = random.uniform(0.05, 0.2) if which == "little" else random.uniform(0.3, 3.0)
        axes = rotation_from_vector(axis / np.linalg.norm(axis) * angle)
    elif which == "sign":
        signs = -signs
    elif which == "force sign":
        signs = np.diag((-1.0, -1.0, -1.0, 1.0, 1.0, 1.0))
    elif which == "swapped":
        axes = np.eye(3)[random.permutation((0, 1, 2))]
    elif which == "mirrored":
        axes = np.diag(random.permutation((-1.0, 1.0, 1.0)))
    sensor.matrix = signs @ np.kron(np.eye(2), axes)
    sensor.in_base = which == "base"
    how = "identify" if random.random() < 0.7 else "tare"
    return Case(sensor, precise(sensor, random), how, sound=False)


def gained(random: Random) -> Case:
    """Gains off: of all axes, of each, of the torques alone, in other units, or with crosstalk."""
    sensor = sound(random)
    which = random.choice(("all", "each", "torques", "units", "crosstalk"))
    if which == "all":
        gains = np.full(6, random.uniform(0.5, 2.0))
    elif which == "each":
        gains = random.uniform(0.7, 1.4, 6)
    elif which == "torques":
        gains = np.array((1.0, 1.0, 1.0, *np.full(3, random.choice((0.1, 10.0, 1000.0)))))
    elif which == "units":
        gains = np.full(6, random.choice((1.0 / 9.81, 9.81, 4.448, 1.0 / 4.448, 0.001)))
    else:
        gains = np.ones(6)
    sensor.matrix = np.diag(gains)
    if which == "crosstalk":
        sensor.matrix = np.eye(6) + np.diag((1.0, 1, 1, 0.1, 0.1, 0.1)) @ random.uniform(-0.1, 0.1, (6, 6))
    how = "identify" if random.random() < 0.7 else "tare"
    return Case(sensor, precise(sensor, random), how, sound=False)


def biased(random: Random) -> Case:
    """A bias beyond the declared one."""
    sensor = sound(random)
    sensor.bias = BIAS_BOUND * random.choice((-1.0, 1.0), 6) * random.uniform(1.2, 6.0)
    return Case(sensor, precise(sensor, random), either(random), sound=False)


def on_a_ramp(random: Random) -> Case:
    """The floor leans: told by the robot, declared, or neither; before the calibration, or after it."""
    sensor = sound(random)
    declared_tilt, told = 0.0, random.random() < 0.4
    angle = math.radians(random.uniform(1.0, 8.0))
    if not told and random.random() < 0.5:
        declared_tilt = angle * 1.05
    heading = random.uniform(-math.pi, math.pi)
    leaning = rotation_from_vector((math.cos(heading) * angle, math.sin(heading) * angle, 0.0)) @ DOWN
    before = random.random() < 0.5

    def then(trial: Trial) -> None:
        trial.gravity = DOWN if before else leaning
        # An identification on a ramp that nobody tells of contradicts itself; a tare, or a level one, does not.
        trial.excuse = LEANING if not trial.case.sound and (trial.excuse or not before) else ""
        trial.use()

    return Case(
        sensor,
        {**precise(sensor, random), **({"floor_tilt": declared_tilt} if declared_tilt else {})},
        either(random),
        sound=told or declared_tilt > 0.0,
        slope=leaning if before else DOWN,
        told=told,
        then=then,
    )


KINDS: dict[str, tuple[float, Callable[[Random], Case]]] = {
    "axes that freeze": (5.0, frozen),
    "axes dead from the start": (3.0, dead),
    "beyond the range": (4.0, saturated),
    "spikes": (4.0, spiking),
    "touched while calibrated": (7.0, touched),
    "touched while tared again": (3.0, touched_again),
    "axes or signs": (8.0, turned),
    "gain, units, crosstalk": (6.0, gained),
    "bias beyond the declared": (3.0, biased),
    "on a ramp": (6.0, on_a_ramp),
}
"""Share of the draws and what draws one."""
