"""What a run says of itself while it is played: to programs also why the task does what it does."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_course import CarrySequence
from services.experiment.play.process import Progress
from services.experiment.play.recording import Event
from shared import topics
from shared.clock import SteadyClock
from shared.messages import Header, TaskStatus
from shared.wire.codec import encode
from shared.wire.subscription import Subscription

COVERED = "no marker in sight: is it covered, or out of the picture?"


def test_the_newest_reason_of_the_task_is_told_once_it_has_been_started(capsys: pytest.CaptureFixture[str]) -> None:
    course = CarrySequence(CARRY.run_named("certified-omni"))
    experiment = SimpleNamespace(course=course, now=lambda: 12.0)
    task = Subscription(topics.TASK_STATUS, SteadyClock())
    progress = Progress(True, task)

    def told(number: int, reason: str) -> dict[str, object]:
        status = TaskStatus("searching", 1.0, reason, 0.0, 0.8, None)
        task.offer(encode(status, Header(number, 7, number, True)))
        progress.show(experiment)
        progress.show(experiment)
        (line,) = capsys.readouterr().out.splitlines()
        return json.loads(line)

    assert told(1, "say start")["reason"] == ""
    course.start = 2.0
    course.phase = "playing"
    course.events.append(Event(3.0, "searching", "looking for the marker"))
    assert told(2, "looking for the marker")["reason"] == "looking for the marker"
    assert told(3, COVERED) == {"phase": "playing", "elapsed": 10.0, "event": "searching", "reason": COVERED}


def test_without_a_task_there_is_no_reason(capsys: pytest.CaptureFixture[str]) -> None:
    course = CarrySequence(CARRY.run_named("certified-omni"))
    course.start = 2.0
    Progress(True, Subscription(topics.TASK_STATUS, SteadyClock())).show(
        SimpleNamespace(course=course, now=lambda: 3.0)
    )
    assert json.loads(capsys.readouterr().out)["reason"] == ""
