"""The course of the carry against a made-up robot and task."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_course import CarrySequence
from services.experiment.carry.carry_protocol import SCRIPTS
from services.experiment.play.course import Ask
from services.experiment.play.observation import Observation
from services.experiment.play.player import PERIOD
from shared import topics

RUN = CARRY.run_named("certified-none")
READY = Observation(
    position=np.zeros(3), speed=0.0, law="certified", mode="ready", wrench_valid=True, task="idle", panel=True
)


class Impatient(CarrySequence):
    """Somebody who has something to say as soon as the robot carries."""

    said = False

    def meanwhile(self, now: float, seen: Observation) -> list[Ask]:
        if self.said or seen.task != "carrying":
            return []
        self.said = True
        return self.ask(now, Ask(topics.TASK_COMMAND, {"command": "release"}))


def asked(sequence: CarrySequence) -> list[dict[str, Any]]:
    """What is asked for until the robot has carried for a while."""
    found, now = [], 0.0
    while now < 12.0:
        started = sequence.start is not None
        seen = dataclasses.replace(READY, task="carrying") if started else READY
        for ask in sequence.step(now, seen):
            found.append(ask.request)
            sequence.answered({"ok": True})
        now += PERIOD
    return found


def test_the_person_plays_the_run_s_script_unless_another_one_is_given() -> None:
    for script, expected in ((None, SCRIPTS["none"]), ("mine", "mine")):
        tare, hand, start, cover = asked(CarrySequence(RUN, script))
        assert tare == {"duration": 1.0} and hand == {"command": "hand", "script": expected}
        assert start == {"command": "start"} and cover == {"command": "cover_marker"}


def test_what_is_asked_meanwhile_comes_first_and_the_course_goes_on_after_it() -> None:
    course = Impatient(RUN)
    requests = asked(course)
    assert [request["command"] for request in requests[2:]] == ["start", "release", "cover_marker"]
    assert [event.name for event in course.events] == ["tare", "start", "carrying", "covered"]
