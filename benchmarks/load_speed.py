"""How fast the load experiment runs with all services in one process under a simulated clock."""

from __future__ import annotations

import time

from benchmarks.experiment_stack import play_run
from benchmarks.table import Row, at_least
from services.experiment.load.load import LOAD
from shared import topics

COMMAND = "python -m benchmarks load_speed"
TARGET = 10.0  # times real time


def rows(quick: bool) -> list[Row]:
    """One row: simulated time over wall time, all runs together (one run if `quick`), start-up not counted."""
    chosen = LOAD.runs[:1] if quick else LOAD.runs
    play_time = simulated = 0.0
    for run in chosen:
        begun = time.perf_counter()
        recording = play_run(LOAD, run)
        play_time += time.perf_counter() - begun
        heard = recording.time(topics.STATE_EE.key)
        simulated += float(heard[-1] - heard[0])
    note = f"{simulated:.0f} s in {play_time:.1f} s, {len(chosen)} runs"
    claim = "load experiment in one process against real time"
    return [at_least(claim, simulated / play_time, TARGET, "", COMMAND, note)]
