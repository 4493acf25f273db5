"""The kinds of sensors that are drawn: sound ones, and what goes wrong with real ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.honest.sensor import DOWN, TOOL_OFFSET, Sensor
from benchmarks.honest.sensor_trial import SETTLED, Case, Trial
from services.wrench.identification import IdentifiedPayload
from services.wrench.parameters import WrenchParameters
from services.wrench.storage import save_payload
from shared.robot.tiago import SENSOR_RANGE
from shared.spatial import Array, rotation_from_vector

Random = np.random.Generator

DEFAULTS = WrenchParameters()
BIAS_BOUND = np.array(DEFAULTS.bias_bound)
NOISE_BOUND = np.array(DEFAULTS.noise_bound)
ZERO_DRIFT = np.array(getattr(DEFAULTS, "zero_drift", (0.1, 0.1, 0.1, 0.01, 0.01, 0.01)))  # [N, Nm] per minute
LATER = "the sensor drifts faster than is declared, and a drift reads as a touch that grows"
QUIET = "a sensor that is declared to have no noise reads the same as a dead one, while the robot stands still"
RARE = "one reading alone reads as a blow, until the next one is there"
LEANING = "the robot stands steeper than is declared, and does not say where down is: that reads as a touch"


def sound(random: Random) -> Sensor:
    """One that keeps the default declarations."""
    away = random.standard_normal(3)
    away *= random.uniform(0.0, DEFAULTS.tool_reach) / np.linalg.norm(away)
    return Sensor(
        mass=random.uniform(0.4, 1.0) * DEFAULTS.tool_mass,
        com=TOOL_OFFSET + away,
        bias=random.uniform(-0.95, 0.95, 6) * BIAS_BOUND,
        sigma=NOISE_BOUND / 5.0 * random.uniform(0.05, 1.0),
        drift=random.uniform(-0.9, 0.9, 6) * ZERO_DRIFT,
    )


def _how(random: Random) -> str:
    return "identify" if random.random() < 0.5 else "tare"


def plain(random: Random) -> Case:
    return Case(sound(random), how=_how(random), rate=float(random.choice((50.0, 100.0, 200.0))))


def other_declaration(random: Random) -> Case:
    """Another sensor than TIAGo's, all of it declared."""
    noise, bias = NOISE_BOUND * random.uniform(0.2, 3.0), BIAS_BOUND * random.uniform(0.3, 5.0)
    mass = DEFAULTS.tool_mass * random.uniform(0.5, 3.0)
    sensor = replace(sound(random), sigma=noise / 5.0, bias=random.uniform(-0.95, 0.95, 6) * bias, mass=0.95 * mass)
    declared = {"noise_bound": tuple(noise), "bias_bound": tuple(bias), "tool_mass": mass}
    return Case(sensor, declared, _how(random))


def drifting(random: Random) -> Case:
    """Within what is declared: for minutes, live, silent, or while the service is down."""
    sensor = sound(random)
    sensor.drift = ZERO_DRIFT * random.choice((-0.95, 0.95), 6)
    wait = random.choice((_wait, _silence, _outage))
    return Case(sensor, how=_how(random), then=lambda trial: wait(trial, random.uniform(0.5, 3.0)), rate=30.0)


def _wait(trial: Trial, minutes: float) -> None:
    trial.wait(minutes)
    trial.use()


def _silence(trial: Trial, minutes: float) -> None:
    """The robot process says nothing for a while, and goes on."""
    trial.published = False
    trial.run(60.0 * minutes)
    trial.resume()
    trial.run(SETTLED)
    trial.use()


def _outage(trial: Trial, minutes: float) -> None:
    """The wrench service is down for a while."""
    trial.kill_service()
    trial.wait(minutes)
    trial.start_service()
    trial.run(SETTLED)
    trial.use()


def drifting_away(random: Random) -> Case:
    """Faster than declared; a second tare shows it, after which no one may rely on the declaration."""
    sensor = sound(random)
    sensor.drift = ZERO_DRIFT * random.uniform(4.0, 12.0) * random.choice((-1.0, 1.0), 6)

    def then(trial: Trial) -> None:
        minutes = random.uniform(1.0, 2.0)
        trial.wait(minutes)
        if trial.calibrate("tare"):
            trial.excuse = ""
            trial.wait(minutes)
            trial.use()

    return Case(sensor, sound=False, excuse=LATER, then=then, rate=30.0)


def restarted(random: Random) -> Case:
    """The robot process is started anew, its sensor has another zero: within the declared bias."""

    def then(trial: Trial) -> None:
        trial.published = False
        trial.run(random.uniform(1.5, 4.0))
        trial.sensor.bias = random.uniform(-0.95, 0.95, 6) * BIAS_BOUND - trial.sensor.drift * trial.stack.now / 60.0
        if random.random() < 0.5:
            trial.kill_service()
            trial.start_service()
        trial.new_session()
        trial.resume()
        trial.run(SETTLED)
        trial.use()

    return Case(sound(random), how=_how(random), then=then)


def from_file(random: Random) -> Case:
    """A payload file of last week: mass and centre are right, the bias is another by now."""
    sensor = sound(random)
    case = Case(sensor, how=random.choice(("nothing", "tare")))
    case.declared = {"payload": _file(sensor, random)}
    return case


def file_of_another_tool(random: Random) -> Case:
    sensor = sound(random)
    other = replace(sensor, mass=sensor.mass + random.choice((-1, 1)) * random.uniform(0.1, 0.3))
    return Case(other, {"payload": _file(sensor, random)}, "tare", sound=False)


def _file(sensor: Sensor, random: Random) -> Callable[[Path], str]:
    """Writes the payload file that an identification of this sensor would have left."""
    bias = random.uniform(-0.95, 0.95, 6) * BIAS_BOUND
    small = np.full(3, 1e-3)

    def write(folder: Path) -> str:
        path = folder / "lastweek.toml"
        found = IdentifiedPayload(
            mass=sensor.mass,
            com=sensor.com,
            force_bias=bias[:3],
            torque_bias=bias[3:],
            sigma_mass=1e-3,
            sigma_com=small,
            sigma_force_bias=10 * small,
            sigma_torque_bias=small,
            residual_rms=np.full(6, 1e-3),
            residual_peak=np.full(6, 2e-3),
            noise=5.0 * sensor.sigma,
            condition=3.0,
            poses=7,
        )
        save_payload(path, found)
        return str(path)

    return write


def digital(random: Random) -> Case:
    """Coarse steps, told."""
    sensor = sound(random)
    sensor.step = sensor.sigma * random.uniform(0.3, 6.0)
    return Case(sensor, _resolved(sensor.step), _how(random))


def digital_untold(random: Random) -> Case:
    sensor = sound(random)
    steps = random.uniform(0.3, 6.0)
    sensor.step = sensor.sigma * steps
    # Up to a standard deviation the noise moves it often enough: that needs no declaration.
    return Case(sensor, how=_how(random), sound=steps <= 1.0)


def noise_free(random: Random) -> Case:
    """A simulator's sensor, or one of which axes read exactly zero; `resolution` says that it is so."""
    sensor = sound(random)
    if random.random() < 0.5:
        sensor.sigma = np.zeros(6)
    else:
        dead = random.choice(6, random.integers(1, 3), replace=False)
        sensor.sigma[dead], sensor.bias[dead] = 0.0, 0.0
        sensor.drift[dead] = 0.0
    return Case(sensor, _resolved(np.where(sensor.sigma == 0.0, 1e-3, 0.0)), _how(random))


def _resolved(step: Array) -> dict[str, Any]:
    return {"resolution": tuple(step.tolist())}


def dead_zone(random: Random) -> Case:
    """Small readings come out as zero: told, or not."""
    sensor = sound(random)
    sensor.dead = NOISE_BOUND * random.uniform(0.5, 4.0)
    sensor.bias = sensor.bias * 0.1
    told = random.random() < 0.5
    return Case(
        sensor, _resolved(sensor.dead) if told else {}, _how(random), sound=told, excuse="" if not told else None
    )


def frozen(random: Random) -> Case:
    """Some axes, or all, keep their last value from some moment on."""
    sensor = sound(random)
    axes = range(6) if random.random() < 0.4 else random.choice(6, random.integers(1, 4), replace=False).tolist()
    quiet = random.random() < 0.3
    if quiet:
        sensor.sigma = np.zeros(6)

    def then(trial: Trial) -> None:
        trial.freeze(*axes)
        trial.run(random.uniform(0.0, 1.0))
        if quiet:
            trial.excuse = QUIET
            trial.push(trial.some_push())
            # Now the weight turns in the sensor's axes, and the readings do not.
            trial.rotation = trial.turned(1.0)
            trial.run(0.3)
            trial.excuse = ""
        trial.use()

    return Case(sensor, _resolved(np.full(6, 1e-3)) if quiet else {}, _how(random), sound=False, then=then, excuse="")


def repeated(random: Random) -> Case:
    """The robot process sends each reading several times, as one does whose driver is slower."""
    return Case(replace(sound(random), repeats=int(random.integers(2, 5))), how=_how(random))


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
            if unknown:
                trial.unseen()
            trial.push(push, 0.5)

    # One that ends early without a word is known by its frozen axis, as soon as that may be told.
    return Case(sensor, how=_how(random), sound=False, then=then, excuse="")


def spiking(random: Random) -> Case:
    sensor = sound(random)
    sensor.spike = NOISE_BOUND * random.choice((-1.0, 1.0), 6) * random.uniform(1.2, 20.0)
    often = random.random() < 0.6
    sensor.every = int(random.integers(8, 40)) if often else 217
    return Case(sensor, how=_how(random), sound=False, excuse="" if often else RARE)


def touched(random: Random) -> Case:
    """Pushed sideways, loaded, turned while it is calibrated."""
    touch = np.concatenate((random.standard_normal(3), random.standard_normal(3)))
    force = (
        touch[:3] / np.linalg.norm(touch[:3]) * random.choice((2.0, 5.0, 15.0, 20.0, 40.0)) * random.uniform(0.5, 1.0)
    )
    if random.random() < 0.4:
        force = DOWN * np.linalg.norm(force)
    torque = touch[3:] / np.linalg.norm(touch[3:]) * random.choice((0.0, 0.5, 3.0, 8.0))
    return Case(sound(random), how=_how(random), sound=False, touch=np.concatenate((force, torque)))


def touched_again(random: Random) -> Case:
    """Tared well, and again a little later while something leans on the tool."""

    def then(trial: Trial) -> None:
        trial.run(2.0)
        # What it would read can hide in the declared bias, but not from the zero that is known already.
        trial.case = replace(trial.case, sound=False, excuse="")
        trial.calibrate("tare", trial.some_push(6.0, 0.0) + np.array((0.0, 0.0, -1.5, 0.0, 0.0, 0.0)))
        trial.use()

    case = Case(sound(random), sound=True, then=then)
    return case


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
    return Case(sensor, how="identify" if random.random() < 0.7 else "tare", sound=False)


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
    return Case(sensor, how="identify" if random.random() < 0.7 else "tare", sound=False)


def biased(random: Random) -> Case:
    """A bias beyond the declared one."""
    sensor = sound(random)
    sensor.bias = BIAS_BOUND * random.choice((-1.0, 1.0), 6) * random.uniform(1.2, 6.0)
    return Case(sensor, how=_how(random), sound=False)


def on_a_ramp(random: Random) -> Case:
    """The floor leans: told by the robot, declared, or neither; before the calibration, or after it."""
    sensor = sound(random)
    declared_tilt, told = 0.0, random.random() < 0.4
    angle = math.radians(random.uniform(1.0, 8.0))
    if not told and random.random() < 0.5 and "floor_tilt" in WrenchParameters.model_fields:
        declared_tilt = angle * 1.05
    heading = random.uniform(-math.pi, math.pi)
    leaning = rotation_from_vector((math.cos(heading) * angle, math.sin(heading) * angle, 0.0)) @ DOWN
    before = random.random() < 0.5

    def then(trial: Trial) -> None:
        trial.gravity = DOWN if before else leaning
        trial.excuse = trial.excuse if trial.case.sound else trial.excuse or LEANING
        trial.use()

    return Case(
        sensor,
        {"floor_tilt": declared_tilt} if declared_tilt else {},
        _how(random),
        sound=told or declared_tilt > 0.0,
        slope=leaning if before else DOWN,
        told=told,
        then=then,
    )


KINDS: dict[str, tuple[float, Callable[[Random], Case]]] = {
    "sound": (10.0, plain),
    "sound, other declarations": (6.0, other_declaration),
    "drift within the declared": (6.0, drifting),
    "drift beyond it": (3.0, drifting_away),
    "robot restarted": (5.0, restarted),
    "payload file of last week": (5.0, from_file),
    "payload file of another tool": (2.0, file_of_another_tool),
    "steps, resolution declared": (4.0, digital),
    "steps, not declared": (3.0, digital_untold),
    "no noise, or none on an axis": (4.0, noise_free),
    "dead zone": (3.0, dead_zone),
    "axes that freeze": (5.0, frozen),
    "each reading sent several times": (3.0, repeated),
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
