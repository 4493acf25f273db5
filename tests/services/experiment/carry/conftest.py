"""One real carry in simulated time, for all tests of what is made of its recording."""

from __future__ import annotations

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.carry import measures
from services.experiment.carry.allowance import Certified, certified
from services.experiment.carry.play import CARRY
from services.experiment.carry.protocol import run_named
from services.experiment.recording import Recording


@pytest.fixture(scope="session")
def carried() -> Recording:
    """certified-omni; whoever changes it copies it first."""
    return play_run(CARRY, run_named("certified-omni"))


@pytest.fixture(scope="session")
def allowance(carried: Recording) -> Certified:
    """What the controller of that carry allows, asked for once."""
    asked: list[Certified] = []

    def ask(*arguments: object) -> Certified:
        asked.append(certified(*arguments))  # type: ignore[arg-type]
        return asked[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measures, "certified", ask)
        measures.measure(carried)
    return asked[0]
