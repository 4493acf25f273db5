"""The load experiment as data: what is held, which limits, which weights at which times, under which laws.

It is the test of Dawson et al., "Barrier functions enable safety-conscious force-feedback control", section
"Validation of the CBF force controller": the robot holds a pose, a bag of 20 N is hung from its tool at 10 s and
made heavier at 17 s. Its "25 N" lies exactly at the limit, where noise decides what happens; here the heavier bag
weighs `HEAVY` (see there).
"""

from __future__ import annotations

from typing import Any

from services.experiment.play.course import Run
from shared.spatial import GRAVITY

HOLD = (0.5, -0.3, 1.0, 0.0, 0.0, 0.0)  # tool in base: x, y, z [m], roll, pitch, yaw [rad]
FORCE_LIMIT = (25.0, 25.0, 25.0)  # [N]
TORQUE_LIMIT = (10.0, 10.0, 10.0)  # [Nm]
LIGHT = 20.0  # weight of the first bag [N]
HEAVY = 28.0  # weight of the heavier bag [N]: over limit + 2 error bounds, see `unambiguous`
LIGHT_AT, HEAVY_AT = 10.0, 17.0  # [s]
UNLOAD_AT = 30.0  # [s]: the heavier bag has been on the ground for a while under every law
END_AT = 45.0  # [s] at the latest; earlier when the tool has come back and rests
FILMED, BESIDE = "certified-100", "paper-30"  # the run that the film shows, and the one on its left
JITTER = 0.020  # [s] that a command may be late: the longest time one command acts is a period and this
MARGIN = 0.5  # [N] kept between what noise can hide and the heavier bag


def mass(weight: float) -> float:
    """Mass [kg] of a bag of `weight` [N]."""
    return weight / GRAVITY


def unambiguous(error_bound: float) -> float:
    """The least weight [N] of the heavier bag that every law must answer, for a force known to +-`error_bound` [N].

    The certified law yields beyond limit + error_bound, as measured; the measurement may read an error_bound too low.
    """
    return FORCE_LIMIT[2] + 2 * error_bound + MARGIN


def _run(name: str, title: str, law: str, rate: float, **controller: Any) -> Run:
    period = round(1.0 / rate + JITTER, 4)
    settings = {
        # Nothing but the bags: whatever else the simulation has costs time.
        "sim": {"scene": "load", "ft_rate": rate, "joint_rate": 100.0},
        "controller": {
            "law": law,
            "lyapunov_rate": 10.0,
            "relaxation_weight": 1.0,
            "barrier_rate": [1.0] * 6,
            "period": period,
            # A hanging bag has no stiffness: this is the stiffness that the certified law is prepared to meet, the
            # bag's landing included. It decides how fast the law lowers: excess / (stiffness * reaction time).
            "contact_stiffness": 2000.0,
            "contact_reach": [0.1, 0.1, 0.1],
            **controller,
        },
    }
    return Run(name, title, law, rate, settings)


RUNS: tuple[Run, ...] = (
    _run("paper-30", "paper's law, 30 Hz", "paper", 30.0),
    _run("certified-30", "certified, 30 Hz", "certified", 30.0),
    _run("certified-100", "certified, 100 Hz", "certified", 100.0),
    _run("rounded-100", "certified, yielding from 0.9 of the limit, 100 Hz", "certified", 100.0, yield_start=0.9),
    _run("stiffness-100", "stiffness 40 N/m, 100 Hz", "stiffness", 100.0, spring_stiffness=[40.0] * 3 + [10.0] * 3),
)
