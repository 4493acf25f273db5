"""One real load experiment in simulated time, for all tests of what is made of its recording."""

from __future__ import annotations

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.load.load import LOAD
from services.experiment.play.recording import Recording


@pytest.fixture(scope="session")
def played() -> Recording:
    """certified-100; whoever changes it copies it first."""
    return play_run(LOAD, LOAD.run_named("certified-100"))
