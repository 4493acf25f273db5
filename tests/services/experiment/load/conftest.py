"""One real load experiment in simulated time, for all tests of what is made of its recording."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.load.load import LOAD
from services.experiment.play.recording import RECORDING, Recording


@pytest.fixture(scope="session")
def played_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """certified-100, as its player records it."""
    path = tmp_path_factory.mktemp("played") / RECORDING
    play_run(LOAD, LOAD.run_named("certified-100"), path=path)
    return path


@pytest.fixture(scope="session")
def played(played_file: Path) -> Recording:
    """Whoever changes it copies it first."""
    return Recording.load(played_file)
