"""Whether the machine kept time during a run, by what the processes count and by the sensor's silence."""

from __future__ import annotations

import numpy as np
import pytest

from services.experiment.measure.disturbance import late_steps, too_busy
from services.experiment.play.recording import Recording


def recording(overruns: list[int], gap: float = 0.01) -> Recording:
    """Health twice a second from half a second before the start, of a loop at 100 Hz; samples with one gap [s]."""
    time = 0.5 * np.arange(len(overruns)) - 0.5
    health = {"time": time, "overruns": np.array(overruns), "loop_hz": np.full(len(time), 100.0)}
    samples = np.concatenate((np.arange(0.0, 1.0, 0.01), 1.0 + gap + np.arange(0.0, 1.0, 0.01)))
    return Recording({}, topics={"health/sim": health, "sensor/ft": {"time": samples}})


@pytest.mark.parametrize(
    ("overruns", "share"),
    [
        ([0, 0, 0, 0, 0], 0.0),
        ([0, 50, 50, 50, 50], 0.0),  # all of them before the start
        ([0, 50, 51, 52, 53], 0.02),
        ([0, 50, 53, 0, 3], 0.04),  # started again in between
    ],
)
def test_steps_count_from_the_start_on(overruns: list[int], share: float) -> None:
    assert late_steps(recording(overruns)) == {"sim": pytest.approx(share)}


def test_who_was_heard_once_has_no_share() -> None:
    assert late_steps(recording([0, 5])) == {}


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (recording([0, 0, 1, 2, 3]), ""),
        (recording([0, 0, 5, 6, 9]), "6.0 % of the steps of sim were late (bound 2 %)"),
        (recording([0, 0, 0, 0, 0], gap=0.3), "the force sensor was silent for 310 ms (bound 150 ms)"),
    ],
    ids=["in time", "late steps", "silence"],
)
def test_a_machine_that_was_too_busy_is_told_by_what_it_shows(found: Recording, said: str) -> None:
    assert too_busy(found) == said
