"""One real carry in simulated time, for all tests of what is made of its recording."""

from __future__ import annotations

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.carry.carry import CARRY
from services.experiment.play.recording import Recording


@pytest.fixture(scope="session")
def carried() -> Recording:
    """certified-omni; whoever changes it copies it first."""
    return play_run(CARRY, CARRY.run_named("certified-omni"))
