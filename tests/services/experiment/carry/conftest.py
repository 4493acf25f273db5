"""One real carry in simulated time, for all tests of what is made of its recording."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.carry.carry import CARRY
from services.experiment.play.recording import RECORDING, Recording


@pytest.fixture(scope="session")
def carried_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """certified-omni, as its player records it."""
    path = tmp_path_factory.mktemp("carried") / RECORDING
    play_run(CARRY, CARRY.run_named("certified-omni"), path=path)
    return path


@pytest.fixture(scope="session")
def carried(carried_file: Path) -> Recording:
    """Whoever changes it copies it first."""
    return Recording.load(carried_file)
