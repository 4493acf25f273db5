"""The benchmark of honesty: it runs, a draw is the same each time, and a service that lies is found out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from benchmarks.honest import report
from benchmarks.honest.draws import KINDS, Draw, plan
from benchmarks.honest.verdict import Verdict
from services.task.task import Task
from services.wrench.wrench import Wrench
from shared.service import Inputs, Output
from shared.topics import TASK_STATUS, WRENCH_EXTERNAL


class LyingWrench(Wrench):
    """States six newtons that are not there, with a small bound."""

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        outputs = super().step(inputs, dt)
        for output in outputs:
            if output.topic is WRENCH_EXTERNAL:
                message = output.message
                output.message = message.replaced(force=message.force + 6.0, error_bound=np.full(6, 1.0))
        return outputs


class LyingTask(Task):
    """Sees the marker three centimetres beside where it is."""

    def step(self, inputs: Inputs, dt: float) -> Iterator[Output]:
        for output in super().step(inputs, dt):
            marker = output.message.marker if output.topic is TASK_STATUS else None
            if marker is not None:
                beside = marker.replaced(position=marker.position + np.array((0.0, 0.03, 0.0)))
                output.message = output.message.replaced(marker=beside)
            yield output


@pytest.mark.parametrize("kind", ("sound", "sound, other declarations", "each reading sent several times"))
def test_a_sound_sensor_is_accepted_and_a_lie_about_it_is_false(kind: str) -> None:
    for number in range(3):
        verdict = Draw(1, kind, number).play()
        assert verdict == Draw(1, kind, number).play(), "the same each time"
        assert verdict == Verdict(kind, number, sound=True)
    assert "true 0.00" in Draw(1, kind, 0).play(service=LyingWrench).false


def test_a_sound_camera_is_believed_and_a_lie_about_it_is_false() -> None:
    assert Draw(1, "rectified picture", 0).play() == Verdict("rectified picture", 0, sound=True)
    assert "off by 3" in Draw(1, "rectified picture", 0).play(service=LyingTask).false


def test_a_sensor_that_freezes_is_refused_in_its_words() -> None:
    verdicts = [Draw(1, "axes that freeze", number).play() for number in range(4)]
    assert not any(verdict.false for verdict in verdicts)
    assert any("stuck" in verdict.refused for verdict in verdicts)


def test_a_missed_target_is_said() -> None:
    verdicts = [
        Verdict("sound", 0, True),
        Verdict("spikes", 1, False, false="fx 1 ± 0.1"),
        Verdict("sound", 2, True, "no"),
    ]
    assert [row.met for row in report.rows(verdicts, "")] == [False, False]
    assert [row.met for row in report.rows(verdicts[:1], "")] == [True, True]
    assert report.counts(verdicts) == (3, 2, 1, 1, 0, 0, 1, 0)


def test_every_kind_is_drawn() -> None:
    assert {draw.kind for draw in plan(0, 10)} == set(KINDS)
    assert len(plan(0, 2000)) == pytest.approx(2000, abs=20)
