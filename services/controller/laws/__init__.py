"""The control laws, and the one that the parameters name."""

from __future__ import annotations

from services.controller.laws.certified import CertifiedLaw
from services.controller.laws.law import Law
from services.controller.laws.paper_and_spring import PaperLaw, StiffnessLaw
from services.controller.laws.qp import Timer, no_timer
from services.controller.parameters import ControllerParameters

LAWS: dict[str, type[Law]] = {law.name: law for law in (CertifiedLaw, PaperLaw, StiffnessLaw)}


def make_law(parameters: ControllerParameters, timer: Timer = no_timer, previous: Law | None = None) -> Law:
    """The law that the parameters name.

    Args:
        parameters: of the controller.
        timer: steady nanoseconds, to measure the solver with.
        previous: the law in force so far; what it has commanded stays accounted for.
    """
    return LAWS[parameters.law](parameters, timer, previous)
