"""The kinds of sensors that are drawn: sound ones, and what goes wrong with real ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.honest.sensor import TOOL_OFFSET, Sensor
from benchmarks.honest.sensor_trial import SETTLED, Case, Trial
from services.wrench.identification import IdentifiedPayload
from services.wrench.parameters import WrenchParameters
from services.wrench.storage import save_payload
from shared.spatial import GRAVITY, Array

Random = np.random.Generator

DEFAULTS = WrenchParameters()
BIAS_BOUND = np.array(DEFAULTS.bias_bound)
NOISE_BOUND = np.array(DEFAULTS.noise_bound)
ZERO_DRIFT = np.array(DEFAULTS.zero_drift)  # [N, Nm] per minute
COARSE = "too few different readings have been seen to know of steps or a dead zone"
LATER = "the sensor drifts faster than is declared, and a drift reads as a touch that grows"


def sound(random: Random) -> Sensor:
    """One that keeps the default declarations."""
    away = random.standard_normal(3)
    away *= random.uniform(0.0, DEFAULTS.tool_reach) / np.linalg.norm(away)
    return Sensor(
        mass=random.uniform(0.4, 1.0) * DEFAULTS.tool_mass,
        com=TOOL_OFFSET + away,
        bias=random.uniform(-0.9, 0.9, 6) * BIAS_BOUND,
        sigma=NOISE_BOUND / 5.0 * random.uniform(0.05, 1.0),
        drift=random.uniform(-0.9, 0.9, 6) * ZERO_DRIFT,
    )


def precise(sensor: Sensor, random: Random) -> dict[str, Any]:
    """Makes most sensors ten times less noisy, as declared: then nothing else hides in what is allowed for noise."""
    if random.random() < 0.3:
        return {}
    sensor.sigma = 0.1 * sensor.sigma
    return {"noise_bound": tuple((0.1 * NOISE_BOUND).tolist())}


def _near(bias: Array, random: Random) -> Array:
    """Another bias (6,) of the same sensor: within what is declared of both and of their difference."""
    most = 0.9 * BIAS_BOUND
    return random.uniform(np.maximum(-most, bias - most), np.minimum(most, bias + most))


def either(random: Random) -> str:
    return "identify" if random.random() < 0.5 else "tare"


def plain(random: Random) -> Case:
    return Case(sound(random), how=either(random), rate=float(random.choice((50.0, 100.0, 200.0))))


def other_declaration(random: Random) -> Case:
    """Another sensor than TIAGo's, all of it declared."""
    noise, bias = NOISE_BOUND * random.uniform(0.2, 3.0), BIAS_BOUND * random.uniform(0.3, 5.0)
    mass = DEFAULTS.tool_mass * random.uniform(0.5, 3.0)
    sensor = replace(sound(random), sigma=noise / 5.0, bias=random.uniform(-0.95, 0.95, 6) * bias, mass=0.95 * mass)
    declared = {"noise_bound": tuple(noise.tolist()), "bias_bound": tuple(bias.tolist()), "tool_mass": mass}
    return Case(sensor, declared, either(random))


def drifting(random: Random) -> Case:
    """Within what is declared: for minutes, live, silent, or while the service is down."""
    sensor = sound(random)
    declared = precise(sensor, random)
    most = ZERO_DRIFT
    if random.random() < 0.5:
        # As a strain gauge warms up.
        most = ZERO_DRIFT * random.uniform(5.0, 40.0)
        declared["zero_drift"] = tuple(most.tolist())
    sensor.drift = 0.95 * most * random.choice((-1.0, 1.0), 6)
    # It stays within the declared bias, on its way through zero.
    sensor.bias = -np.sign(sensor.drift) * np.abs(sensor.bias)
    wait = random.choice((_wait, _silence, _outage))
    minutes = random.uniform(0.5, 3.0)
    return Case(sensor, declared, either(random), then=lambda trial: wait(trial, minutes), rate=30.0)


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
    declared = precise(sensor, random)
    sensor.drift = ZERO_DRIFT * random.uniform(10.0, 40.0) * random.choice((-1.0, 1.0), 6)

    def then(trial: Trial) -> None:
        minutes = random.uniform(0.4, 1.2)
        trial.wait(minutes)
        if trial.calibrate("tare"):
            trial.excuse = ""
            trial.wait(minutes)
            trial.use()

    return Case(sensor, declared, sound=False, excuse=LATER, then=then, rate=30.0)


def restarted(random: Random) -> Case:
    """The robot process is started anew, its sensor has another zero: within the declared bias."""

    def then(trial: Trial) -> None:
        trial.published = False
        trial.run(random.uniform(1.5, 4.0))
        trial.sensor.bias = _near(trial.sensor.bias, random)
        if random.random() < 0.5:
            trial.kill_service()
            trial.start_service()
        trial.new_session()
        trial.resume()
        trial.run(SETTLED)
        trial.use()

    sensor = sound(random)
    return Case(sensor, precise(sensor, random), either(random), then=then)


def from_file(random: Random) -> Case:
    """A payload file of last week: mass and centre are right, the bias is another by now."""
    sensor = sound(random)
    declared = precise(sensor, random)
    return Case(sensor, {**declared, "payload": _file(sensor, random)}, random.choice(("nothing", "tare")))


def file_of_another_tool(random: Random) -> Case:
    sensor = sound(random)
    other = replace(sensor, mass=sensor.mass + random.choice((-1, 1)) * random.uniform(0.1, 0.3))
    return Case(other, {"payload": _file(sensor, random)}, "tare", sound=False)


def _file(sensor: Sensor, random: Random) -> Callable[[Path], str]:
    """Writes the payload file that an identification of this sensor would have left."""
    bias = _near(sensor.bias, random)
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
    return Case(sensor, resolved(sensor, sensor.step), either(random))


def digital_untold(random: Random) -> Case:
    """Steps that nobody tells of: within the declared noise, or beyond it."""
    sensor = sound(random)
    sensor.sigma = NOISE_BOUND / 5.0 * random.uniform(0.1, 0.6)
    sensor.step = NOISE_BOUND * random.choice((random.uniform(0.02, 0.8), random.uniform(1.0, 5.0)))
    sound_so = bool(sensor.step[0] <= sensor.sigma[0])  # the noise moves it often enough: that needs no declaration
    return Case(sensor, how=either(random), sound=sound_so, excuse=COARSE, then=_again)


def _again(trial: Trial) -> None:
    """By now its readings have shown what they are like."""
    trial.excuse = ""
    trial.use()


def noise_free(random: Random) -> Case:
    """A simulator's sensor, or one of which axes read exactly zero; `resolution` says that it is so."""
    sensor = sound(random)
    if random.random() < 0.5:
        sensor.sigma = np.zeros(6)
    else:
        dead = random.choice(6, random.integers(1, 3), replace=False)
        sensor.sigma[dead], sensor.bias[dead] = 0.0, 0.0
        sensor.drift[dead] = 0.0
    return Case(sensor, resolved(sensor, np.where(sensor.sigma == 0.0, 1e-3, 0.0)), either(random))


def resolved(sensor: Sensor, step: Array) -> dict[str, Any]:
    """Declares the width of steps or of a dead zone (6,), and the noise with what they hide."""
    return {
        "resolution": tuple(step.tolist()),
        "noise_bound": tuple(np.maximum(NOISE_BOUND, 5.0 * sensor.sigma + step)),
    }


def dead_zone(random: Random) -> Case:
    """Small readings come out as zero: told, or not."""
    sensor = sound(random)
    sensor.dead = NOISE_BOUND * random.uniform(0.5, 4.0)
    sensor.bias = sensor.bias * 0.1
    if random.random() < 0.5:
        return Case(sensor, resolved(sensor, 2.0 * sensor.dead), either(random))
    if random.random() < 0.5:
        return _within(sensor, random)
    # Small forces after large ones let an axis repeat zero: that need not be known at once.
    return Case(sensor, how=either(random), sound=False, excuse=COARSE, then=_again, lulls=True)


def _within(sensor: Sensor, random: Random) -> Case:
    """A light tool that hides in a dead zone as a whole: nothing changes until it is pushed, nor long after."""
    sensor.sigma = sensor.sigma * random.uniform(0.1, 1.0)
    sensor.mass = random.uniform(0.05, 0.12) * sensor.dead[0] / GRAVITY
    sensor.bias = random.uniform(-0.2, 0.2, 6) * sensor.dead
    # Declared, since a tool of `tool_mass` would have to show when it turns.
    return Case(sensor, {"tool_mass": 1.2 * sensor.mass}, then=_rest)


def _rest(trial: Trial) -> None:
    for _ in range(6):
        trial.push(trial.some_push(), 0.5)
    trial.run(8.0)
    trial.use()
    trial.run(3.0)


def repeated(random: Random) -> Case:
    """The robot process sends each reading several times, as one does whose driver is slower."""
    return Case(replace(sound(random), repeats=int(random.integers(2, 5))), how=either(random))


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
    "each reading sent several times": (3.0, repeated),
}
"""Share of the draws and what draws one."""
