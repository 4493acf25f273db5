"""The runs in which the robot is heard: at a third of the usual rate, so that the recordings stay small."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from services.experiment.carry import carry_protocol as carry
from services.experiment.carry.carry import CARRY
from services.experiment.load.load import LOAD
from services.experiment.play.course import Run
from services.experiment.spec import Experiment

RATE = 33.0  # [Hz]
PERIOD = 0.0503  # [s]: one of those, and 20 ms for a command that is late
CAMERA_RATE = 3.0  # [Hz]: pictures are what takes most room


def _slower(run: Run) -> Run:
    further: dict[str, dict[str, Any]] = {
        "sim": {"ft_rate": RATE, "camera_rate": CAMERA_RATE},
        "controller": {"period": PERIOD},
    }
    return replace(run, settings={name: values | further.get(name, {}) for name, values in run.settings.items()})


ROBOTS: dict[str, tuple[Experiment, Run]] = {
    "carry": (CARRY, _slower(carry.run("certified", "omni"))),
    "load": (LOAD, _slower(LOAD.run_named("certified-100"))),
}
