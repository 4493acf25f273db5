"""What each carry of the sweep is like, drawn from its seed alone."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from benchmarks.carry.person import Habit, Manner, script
from services.experiment.carry import carry_protocol as protocol
from services.experiment.play.course import Run
from shared.spatial import GRAVITY

KINDS = (
    "varied",
    "weak person",
    "varied",
    "30 Hz",
    "varied",
    "2.5 kg",
    "arm only",
    "varied",
    "ground lower",
    "varied",
    "lets go first",
    "varied",
    "ground higher",
    "250 Hz",
    "varied",
    "paper",
    "rubber pads",
    "arm only",
    "varied",
    "drops his end",
)
"""The kind of case number n is the one at n modulo their number."""
HARDER_KINDS = (
    "jerks",
    "hesitates",
    "corrects",
    "hurries",
    "twice as stiff",
    "half as stiff",
    "drops his end",
    "lets go first",
)
"""The same of the sweep with harder people."""
STIFFNESS = {"twice as stiff": 2.0, "half as stiff": 0.5}
"""Of the person's arms, over what the controller is told."""
UNEXPECTED_GROUND = 0.1
"""How much lower or higher than the task was told the ground is [m]."""
RUBBER = 0.9
"""Friction of plain rubber pads on foam: a panel pivots in the fingers long before a limit is reached."""


Changes = dict[str, dict[str, Any]]
"""Settings by service and name."""


@dataclass(frozen=True)
class Case:
    """One carry.

    Attributes:
        seed: that it was drawn from.
        kind: what is special about it.
        run: the stack's configuration.
        script: what the person does.
        ends_held: the person lets go of the far end in the middle: the robot has to keep its own and say why it waits.
        drawn: the figures that tell it from others, for people.
    """

    seed: int
    kind: str
    run: Run
    script: str
    ends_held: bool = False
    drawn: dict[str, Any] = field(default_factory=dict)


def case(seed: int, overrides: Changes | None = None, harder: bool = False) -> Case:
    """The carry of a seed.

    Args:
        seed: of all that is drawn.
        overrides: take the place of what the services were set to.
        harder: with a person of ``HARDER_KINDS``; panel, sensors and the rest are those of the same seed.
    """
    kinds = HARDER_KINDS if harder else KINDS
    kind = kinds[seed % len(kinds)]
    draw = np.random.default_rng(seed)
    mass = 2.5 if kind == "2.5 kg" else _between(draw, 1.0, 2.5)
    told = mass * _between(draw, 0.8, 1.2) if draw.random() < 0.5 else mass
    length, width = _between(draw, 0.9, 1.5), _between(draw, 0.6, 0.8)
    rate = {"30 Hz": 30.0, "250 Hz": 250.0}.get(kind, protocol.RATE)
    base = "none" if kind == "arm only" else ("omni", "differential")[int(draw.integers(2))]
    law = "paper" if kind == "paper" else "certified"
    manner = Manner.drawn(draw, arm_only=base == "none", kind=kind)
    if harder:
        manner = replace(manner, habit=Habit.drawn(np.random.default_rng((seed, 1)), kind))
    from_edge, aside = _between(draw, 0.20, 0.30), _between(draw, -0.05, 0.05)
    expected_ground = _between(draw, -0.03, 0.03)
    if kind == "ground lower":
        expected_ground = UNEXPECTED_GROUND
    elif kind == "ground higher":
        expected_ground = -UNEXPECTED_GROUND
    sim = {
        "seed": seed,
        "panel_size": [length, width, protocol.PANEL_SIZE[2]],
        "panel_mass": mass,
        "panel_stiffness": _foam(mass, width),
        "panel_friction": _between(draw, 0.3, 1.0),
        "grip_friction": RUBBER if kind == "rubber pads" else _between(draw, 2.5, 4.5),
        "panel_position": [_between(draw, 0.56, 0.64), _between(draw, -0.44, -0.34), _between(draw, 0.74, 0.82)],
        "panel_yaw": math.radians(_between(draw, -10.0, 10.0)),
        "marker_position": [from_edge - length / 2.0, aside],
        "light": _between(draw, 0.4, 1.3),
        "camera_noise": _between(draw, 0.5, 8.0),
        "camera_rate": 5.0,
        "ft_rate": rate,
        "ft_noise": [_between(draw, 0.5, 2.0) * std for std in (0.1,) * 3 + (0.005,) * 3],
        "ft_bias": [_between(draw, -3.0, 3.0) for _ in range(3)] + [_between(draw, -0.2, 0.2) for _ in range(3)],
        "person_force": _between(draw, 40.0, 80.0),
        "person_torque": 5.0 if kind == "weak person" else _between(draw, 12.0, 20.0),
        "person_stiffness": STIFFNESS.get(kind, 1.0) * protocol.CONTACT_STIFFNESS,
    }
    task = {
        "panel_mass": told,
        "panel_length": length,
        "panel_width": width,
        "ground_height": expected_ground,
        # The tool's origin comes to the middle of the edge; measured on the panel to half a centimetre.
        "grasp_position": [
            aside + _between(draw, -0.005, 0.005),
            -from_edge + _between(draw, -0.005, 0.005),
            -protocol.PANEL_SIZE[2] / 2.0,
        ],
    }
    if kind == "ground higher":
        # What it is told would be out of the arm's reach for some panels; where the ground really is, it is not.
        task["reach_down"] = protocol.PANEL_SIZE[1] / 2.0 - UNEXPECTED_GROUND
    # As `protocol.run` has it for 100 Hz: half as long again as the sensor's own period, at least.
    controller = {"period": 0.05} if rate < protocol.RATE else {}
    drawn = {
        "base": base,
        "kg": round(mass, 2),
        "told": round(told / mass, 2),
        "size": f"{length:.2f} x {width:.2f}",
        "yaw": round(math.degrees(sim["panel_yaw"])),
        "ground": round(-expected_ground, 3),
        "pace": round(manner.pace, 2),
    }
    changes: Changes = {"sim": sim, "task": task, "controller": controller}
    for service, values in (overrides or {}).items():
        changes[service] = changes.get(service, {}) | values
    return Case(seed, kind, _run(law, base, rate, changes), script(manner), manner.drops, drawn)


def _run(law: str, base: str, rate: float, changes: Changes) -> Run:
    nominal = protocol.run(law, base)
    settings = copy.deepcopy(nominal.settings)
    for service, values in changes.items():
        settings[service] = settings.get(service, {}) | values
    return Run(nominal.name, nominal.title, law, rate, settings, nominal.further)


def _between(draw: np.random.Generator, low: float, high: float) -> float:
    return float(draw.uniform(low, high))


def _foam(mass: float, width: float) -> float:
    """Stiffness [N/m] at which the panel stands on its edge by itself, with a tenth to spare: see `panel_stiffness`."""
    enough = 4.0 * mass * GRAVITY * (width / 2.0) / protocol.PANEL_SIZE[2] ** 2
    return float(min(20000.0, max(12000.0, 1.1 * enough)))
