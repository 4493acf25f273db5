"""Plays one case with all services in one process under a simulated clock."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.carry.cases import Case, Changes, case
from benchmarks.carry.course import SweepCourse
from benchmarks.carry.judge import Verdict, judge
from benchmarks.carry.witness import Witness
from benchmarks.experiment_stack import LONGEST, Staged
from services.experiment.carry import carry_protocol as protocol
from services.experiment.carry.carry_claims import STATES
from services.experiment.carry.carry_course import GIVEN_UP
from services.experiment.play.course import Failed
from services.experiment.play.player import Player
from services.experiment.play.recording import Event
from services.task.parameters import TaskParameters
from shared.messages import Stop
from shared.topics import STOP


@dataclass(frozen=True)
class Played:
    """A case with what became of it.

    Attributes:
        case: that was played.
        verdict: on it.
        events: of its course, in time since the start.
        seen: by the witness.
    """

    case: Case
    verdict: Verdict
    events: list[Event]
    seen: Mapping[str, np.ndarray]


def play(chosen: Case) -> Played:
    """Play a case to its end."""
    course = SweepCourse(chosen)
    trouble = ""
    with tempfile.TemporaryDirectory() as folder:
        staged = Staged(partial(Player, course, None, {}), chosen.run, Path(folder))
        warning = TaskParameters.of(chosen.run.settings["task"]).warning
        witness = Witness(staged.simulator, protocol.PANEL_SIZE[2], warning)
        staged.stack.add(witness)

        def done() -> bool:
            if course.resumes:
                course.resumes = False
                staged.stack.client.publish(STOP, Stop(False))
            return course.done

        try:
            staged.stack.run(LONGEST, done=done)
        except Failed as problem:
            trouble = str(problem)
        if not course.done and not trouble:
            trouble = f"still {course.phase} after {LONGEST:g} s"
    start = course.start or 0.0
    events = [Event(event.time - start, event.name, event.detail) for event in course.events]
    states = [event for event in events if event.name in {*STATES, *GIVEN_UP}]
    end = states[-1] if states else Event(0.0, "", trouble)
    limits = np.array(protocol.FORCE_LIMIT + protocol.TORQUE_LIMIT)
    verdict = judge(witness.seen(), limits, end.name, end.detail, course.told, trouble, chosen.ends_held)
    return Played(chosen, verdict, events, witness.seen())


def verdict_of(seed: int, overrides: Changes, harder: bool) -> tuple[Case, Verdict]:
    """The case of a seed and the verdict on it: what was seen stays in the process that played it, it is large."""
    played = play(case(seed, overrides, harder))
    return played.case, played.verdict
