"""The controller's own law classes, set up for a case."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from benchmarks.contact.adversary import YIELD_START
from benchmarks.contact.cases import Case, Target
from services.controller.laws.certified import CertifiedLaw
from services.controller.laws.law import Law, LawInput
from services.controller.laws.paper_and_spring import PaperLaw, StiffnessLaw
from services.controller.parameters import ControllerParameters
from shared.spatial import Array

_SETTINGS: dict[str, tuple[type[Law], dict[str, Any]]] = {
    "paper": (PaperLaw, {"law": "paper"}),
    "stiffness": (StiffnessLaw, {"law": "stiffness"}),
    "certified": (CertifiedLaw, {}),
    "certified-rounded": (CertifiedLaw, {"yield_start": YIELD_START}),
}
LAWS = tuple(_SETTINGS)


class CaseLaw:
    """A law of the controller with what a case declares to it.

    Attributes:
        law: the controller's.
        ticks: how often it was asked.
        failures: why it braked instead of answering, once per tick in which it did.
    """

    def __init__(self, law: Law) -> None:
        self.law = law
        self.ticks = 0
        self.failures: list[str] = []

    def twist(
        self, wrench: Array, position: Array, rotation: Array, target: Target, case: Case, dt: float
    ) -> Array:
        """Commanded twist (6,), see ``simulate.Law``."""
        output = self.law.step(
            LawInput(
                wrench=wrench - case.nominal,
                limit=case.limit,
                error_bound=case.error_bound,
                position=position,
                rotation=rotation,
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
        **_SETTINGS[name][1],
        barrier_rate=(1.0, 1.0, 1.0, torque_rate, torque_rate, torque_rate),
        period=timing.declared_period,
        delay=timing.declared_delay,
        lag=timing.declared_lag,
    )


def make_law(name: str, case: Case) -> CaseLaw:
    """The law called ``name`` in ``LAWS``, at rest."""
    return CaseLaw(_SETTINGS[name][0](parameters(name, case)))
