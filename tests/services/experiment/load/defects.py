"""What can go wrong in a load experiment: each takes a copy of a good recording, and spoils it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from services.experiment.load.load_protocol import FORCE_LIMIT, HEAVY_AT, LIGHT_AT, UNLOAD_AT
from services.experiment.play.recording import Recording

Defect = Callable[[Recording], None]
LANDED = 22.0  # [s]: the heavier bag is on the ground
BRAKES = (18.2, 19.2, 20.2)  # [s]


def add(topic: str, name: str, axis: int, start: float, end: float, value: float, rate: float = 0.0) -> Defect:
    """Something is added to a component for a time [s]; it swings with that amplitude if there is a rate [rad/s]."""

    def spoil(recording: Recording) -> None:
        time = recording.time(topic)
        then = (time >= start) & (time < end)
        recording.series(topic, name)[then, axis] += value * np.sin(rate * time[then]) if rate else value

    return spoil


def moved(start: float, end: float, value: float, rate: float = 0.0) -> Defect:
    """The tool is higher [m] for a time."""
    return add("state/ee", "position", 2, start, end, value, rate)


sags = moved(LIGHT_AT, HEAVY_AT, -0.02)
bounces = moved(HEAVY_AT, LANDED, 0.03, 6.0)
stays_low = moved(UNLOAD_AT, np.inf, -0.05)
pushed_sideways = add("wrench/external", "force", 0, LIGHT_AT, HEAVY_AT, 26.0)
swings = add("wrench/external", "force", 2, HEAVY_AT, LANDED, 3.0, 20.0)


def swings_now_and_then(recording: Recording) -> None:
    """The load swings as after brakes, but there were none."""
    for start in BRAKES:
        add("wrench/external", "force", 2, start, start + 0.4, 10.0, 30.0)(recording)


def never_lowers(recording: Recording) -> None:
    """The heavier bag stays in the air."""
    time = recording.time("sim/world")
    recording.series("sim/world", "bag.height")[(time > HEAVY_AT) & (time < UNLOAD_AT)] = 0.3


def keeps_pressing(recording: Recording) -> None:
    """The load is over the limit with the bag on the ground."""
    time = recording.time("wrench/external")
    on_ground = (time > LANDED) & (time < UNLOAD_AT)
    recording.series("wrench/external", "force")[on_ground, 2] = -FORCE_LIMIT[2] - 2.0


def braked(recording: Recording) -> None:
    """The gate brakes on the way down, and the load swings after that."""
    swings_now_and_then(recording)
    for start in BRAKES:
        recording.series("state/robot", "held")[recording.time("state/robot") >= start] += 1


def braked_and_swings(recording: Recording) -> None:
    """The load swings all the way, besides."""
    braked(recording)
    swings(recording)


def stalled(recording: Recording) -> None:
    """No sample comes for a second and a half, and the controller rests."""
    samples = recording.topics["sensor/ft"]
    silent = (samples["time"] > 12.0) & (samples["time"] < 13.5)
    recording.topics["sensor/ft"] = {name: values[~silent] for name, values in samples.items()}
    time, state = (recording.series("control/status", name) for name in ("time", "state"))
    state[(time > 12.0) & (time < 13.5)] = "braking"


def late(recording: Recording) -> None:
    """Every twentieth step of the simulation is late, by its own count."""
    health = recording.topics["health/sim"]
    health["overruns"] = np.round(0.05 * health["loop_hz"] * np.maximum(health["time"], 0.0)).astype(int)


def broken_off(recording: Recording) -> None:
    """The run ends with the first bag."""
    recording.events = [event for event in recording.events if event.time <= LIGHT_AT]
