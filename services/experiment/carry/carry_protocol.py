"""The carry as data: which panel, which limits, what the person does, under which laws, with which base.

It is the scenario of Dawson et al., "Barrier functions enable safety-conscious force-feedback control", section
"Collaborative carrying task", with its limits and gains: `task` has 10 N along each axis, along z less half the panel's
weight, and 0.5, 3, 3 Nm by default.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from services.experiment.play.course import Run

PANEL_SIZE = (1.2, 0.6, 0.05)  # length, width, thickness [m]
PANEL_MASS = 1.5  # [kg]
MARKER = 7  # number of the printed marker
MARKER_SIZE = 0.15  # [m]
MARKER_POSITION = (-0.35, 0.0)  # [m] from the panel's centre: 0.25 m from the edge that is grasped
FORCE_LIMIT = (10.0, 10.0, 10.0)  # [N], the paper's
TORQUE_LIMIT = (0.5, 3.0, 3.0)  # [Nm], the paper's
PAYLOAD = Path(__file__).with_name("gripper.toml")  # the empty gripper, identified
END_AT = 150.0  # [s] at the latest; earlier when the robot has gone back and the person has let go
EXPECTED = 65.0  # [s] that it takes if nothing goes wrong, for the progress
RATE = 100.0  # [Hz] of the force-torque sensor
LAWS = ("certified", "paper", "stiffness")
BASES = {"omni": "omnidirectional base", "differential": "differential base", "none": "arm only"}
FILMED, BESIDE = "certified-omni", "paper-omni"  # the run that the film shows, and the one on its left


@dataclass(frozen=True)
class Guidance:
    """A movement by which the person guides the robot.

    Attributes:
        name: of it.
        way: "along" the panel, "across" it (both horizontal), or "roll" about its long axis.
        amount: how far [m, rad]; forwards (away from the robot), to the left, or right-handed.
    """

    name: str
    way: str
    amount: float


SCRIPTS = {
    base: (Path(__file__).with_name("arm_only.toml").read_text(encoding="utf-8") if base == "none" else "carry")
    for base in BASES
}
"""What the person does; the arm alone cannot follow somebody who walks."""

_TURNS = (
    Guidance("twist", "roll", math.radians(20.0)),
    Guidance("twist back", "roll", math.radians(-20.0)),
    Guidance("turn", "roll", math.radians(90.0)),
)
_WALK = (
    Guidance("pull", "along", 0.5),
    Guidance("push", "along", -0.3),
    Guidance("left", "across", 0.4),
    Guidance("right", "across", -0.4),
)
_REACH = (
    Guidance("push", "along", -0.06),
    Guidance("pull", "along", 0.08),
    Guidance("left", "across", 0.2),
    Guidance("right", "across", -0.2),
)
GUIDANCE = {base: (*(_REACH if base == "none" else _WALK), *_TURNS) for base in BASES}
"""The movements in these scripts, in order, for the judge: how far the person wants the far end to go."""

_CONTROLLER: dict[str, Any] = {
    "lyapunov_rate": 10.0,
    "relaxation_weight": 1.0,
    "max_acceleration": [2.0, 2.0, 2.0, 2.5, 1.0, 1.0],
    # The longest time one command acts and the longest way of a sample, on a machine that is busy with other things.
    "period": 0.03,
    "delay": 0.03,
}
CONTACT_STIFFNESS = 500.0  # [N/m], of a person's two arms
_LAW: dict[str, dict[str, Any]] = {
    # A person's two arms at the far end of the panel, which is as wide along the tool's z axis as it is long along x.
    "certified": {"yield_start": 0.8, "contact_stiffness": CONTACT_STIFFNESS, "contact_reach": [1.2, 0.05, 0.3]},
    "paper": {"barrier_rate": [1.0] * 3 + [10.0] * 3},
    "stiffness": {"spring_stiffness": [40.0] * 3 + [10.0] * 3},
}


def run(law: str, base: str) -> Run:
    """The carry under a law, with a base or none.

    Raises:
        KeyError: `law` is none of LAWS or `base` none of BASES.
    """
    base_type = "omni" if base == "none" else base
    return Run(
        name=f"{law}-{base}",
        title=f"{law}, {BASES[base]}",
        law=law,
        rate=RATE,
        settings={
            "sim": {
                "scene": "carry",
                "base_type": base_type,
                "ft_rate": RATE,
                "panel_size": list(PANEL_SIZE),
                "panel_mass": PANEL_MASS,
                "marker_id": MARKER,
                "marker_size": MARKER_SIZE,
                "marker_position": list(MARKER_POSITION),
            },
            "wrench": {"payload": str(PAYLOAD)},
            "controller": {"law": law, **_CONTROLLER, **_LAW[law]},
            "task": {
                "compensation": "payload",
                "panel_mass": PANEL_MASS,
                "marker_id": MARKER,
                "marker_size": MARKER_SIZE,
                "force_limit": list(FORCE_LIMIT),
                "torque_limit": list(TORQUE_LIMIT),
            },
        },
        further=("task",) if base == "none" else ("base", "task"),
    )


RUNS = (run("certified", "omni"), run("certified", "none"), run("paper", "omni"), run("stiffness", "omni"))
"""What is played unless something else is asked for."""
