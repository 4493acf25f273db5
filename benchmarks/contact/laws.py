"""The controller's own law classes, set up for a case."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from benchmarks.contact.adversary import YIELD_START
from benchmarks.contact.cases import Case
from benchmarks.contact.robot import Robot
from services.controller import laws
from services.controller.laws.law import Law, LawInput
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

_SETTINGS: dict[str, dict[str, Any]] = {
    "paper": {"law": "paper"},
    "stiffness": {"law": "stiffness"},
    "certified": {},
    "certified-rounded": {"yield_start": YIELD_START},
}
LAWS = tuple(_SETTINGS)


class CaseLaw:
    """A law of the controller with what a case declares to it.

    Attributes:
        law: the controller's.
        case: what is declared to it.
        ticks: how often it was asked.
        failures: why it braked instead of answering, once per tick in which it did.
    """

    def __init__(self, law: Law, case: Case) -> None:
        self.law, self.case = law, case
        self.ticks = 0
        self.failures: list[str] = []

    def twist(self, wrench: Array, robot: Robot, now: float, dt: float) -> Array:
        """Commanded twist (6,) for a measured wrench (6,), nominal not yet subtracted, at the time ``now`` [s]."""
        case, target = self.case, self.case.target(now)
        output = self.law.step(
            LawInput(
                wrench=wrench - case.nominal,
                limit=case.limit,
                error_bound=case.error_bound,
                position=robot.position,
                rotation=robot.rotation,
                target_position=target.position,
                target_rotation=target.rotation,
                nominal=case.nominal,
            ),
            dt,
        )
        self.ticks += 1
        if output.failure is not None:
            self.failures.append(output.failure)
        return output.twist


def parameters(name: str, case: Case) -> ControllerParameters:
    """The controller's parameters for the law called ``name`` in ``LAWS``."""
    timing = case.timing
    # The paper's alpha: 10 for the torques of its carrying task, 1 in its load experiment.
    torque_rate = 10.0 if case.limit[3] < 1.0 else 1.0
    return ControllerParameters(
        **asdict(case.declared),
        **_SETTINGS[name],
        barrier_rate=(1.0, 1.0, 1.0, torque_rate, torque_rate, torque_rate),
        period=timing.declared_period,
        delay=timing.declared_delay,
        lag=timing.declared_lag,
    )


def make_law(name: str, case: Case) -> CaseLaw:
    """The law called ``name`` in ``LAWS``, at rest."""
    return CaseLaw(laws.make_law(parameters(name, case)), case)
