"""One real carry in simulated time, for all tests of what is made of its recording."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.carry import carry_measures as measures
from services.experiment.carry.allowance import Certified, certified
from services.experiment.carry.carry_protocol import run_named
from services.experiment.carry.experiment import CARRY
from services.experiment.play.recording import Recording

Measure = Callable[[Recording], measures.Measures]


@pytest.fixture(scope="session")
def carried() -> Recording:
    """certified-omni; whoever changes it copies it first."""
    return play_run(CARRY, run_named("certified-omni"))


@pytest.fixture(scope="session")
def allowance(carried: Recording) -> Certified:
    """What the controller of that carry allows, asked for once."""
    found: list[Certified] = []

    def ask(*question: Any) -> Certified:
        found.append(certified(*question))
        return found[-1]

    measures.measure(carried, ask)
    return found[0]


@pytest.fixture
def measure(allowance: Certified) -> Measure:
    """`measures.measure` without a process for each recording."""
    return lambda recording: measures.measure(recording, lambda *_: allowance)
