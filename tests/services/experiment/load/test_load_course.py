"""The course of the experiment against a made-up robot: order, times, and giving up with the reason."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from services.experiment.load import load_protocol as protocol
from services.experiment.load.load import LOAD
from services.experiment.load.load_course import LoadSequence
from services.experiment.play.course import Failed
from services.experiment.play.observation import Observation
from services.experiment.play.player import PERIOD
from shared import topics

RUN = LOAD.run_named("certified-100")
AT_POSE = Observation(
    position=np.array(protocol.HOLD[:3]), speed=0.0, law="certified", mode="ready", wrench_valid=True, error_bound=0.4
)


def play(
    seen: Observation, answer: dict[str, Any] | None = None, until: float = 100.0
) -> tuple[LoadSequence, list[Any]]:
    """Steps at 10 Hz with the same observation, answering every request in the following step."""
    sequence, asked, now = LoadSequence(RUN), [], 0.0
    while not sequence.done and now < until:
        for ask in sequence.step(now, seen):
            asked.append((now, ask))
            if answer is not None:
                sequence.answered(answer)
        now += PERIOD
    return sequence, asked


def test_plays_tare_then_the_loads_at_their_times() -> None:
    sequence, asked = play(AT_POSE, {"ok": True})
    assert sequence.done
    start = sequence.start
    assert start is not None
    assert [ask.query for _, ask in asked] == [topics.WRENCH_TARE] + [topics.SIM_COMMAND] * 3
    times = [now - start for now, ask in asked if ask.query is topics.SIM_COMMAND]
    assert times == pytest.approx([protocol.LIGHT_AT, protocol.HEAVY_AT, protocol.UNLOAD_AT], abs=0.11)
    masses = [ask.request["mass"] for _, ask in asked[1:]]
    assert masses == pytest.approx([20.0 / 9.81, protocol.HEAVY / 9.81, 0.0])
    assert [event.name for event in sequence.events] == ["tare", "start", "light", "heavy", "unload", "end"]


def test_ends_at_the_latest_when_the_tool_does_not_come_back() -> None:
    sequence, now = LoadSequence(RUN), 0.0
    low = dataclasses.replace(AT_POSE, position=np.array([0.5, -0.3, 0.5]))
    while not sequence.done and now < 100.0:
        unloaded = any(event.name == "unload" for event in sequence.events)
        for _ in sequence.step(now, low if unloaded else AT_POSE):
            sequence.answered({"ok": True})
        now += PERIOD
    assert sequence.start is not None
    assert sequence.events[-1].time - sequence.start == pytest.approx(protocol.END_AT, abs=0.2)


def test_a_tare_that_is_refused_once_is_asked_for_again() -> None:
    sequence, asked, now = LoadSequence(RUN), 0, 0.0
    while sequence.start is None and now < 60.0:
        for _ in sequence.step(now, AT_POSE):
            asked += 1
            sequence.answered({"ok": asked > 1, "error": "a sample came late"})
        now += PERIOD
    assert asked == 2
    assert sequence.start is not None


def test_a_refused_tare_waits_for_a_valid_wrench() -> None:
    """As while a stack starts on a busy machine: refusals come at once, and would be used up within seconds."""
    sequence, asked, now = LoadSequence(RUN), [], 0.0
    while sequence.start is None and now < 60.0:
        # The wrench has been valid for a moment, and is again from 15 s on.
        seen = dataclasses.replace(AT_POSE, wrench_valid=now < 0.05 or now > 15.0)
        for _ in sequence.step(now, seen):
            asked.append(now)
            sequence.answered({"ok": now > 15.0, "error": "sensor/ft is 168 ms old"})
        now += PERIOD
    assert sequence.start is not None
    assert [one < 2.0 for one in asked] == [True, False]


YES, NO = {"ok": True}, {"ok": False, "error": "the tool moves"}


@pytest.mark.parametrize(
    ("changes", "answer", "reason"),
    [
        ({"position": None}, None, "state/ee.*robot process running"),
        ({"wrench_valid": False, "trouble": "stuck"}, None, "wrench/external is not valid. stuck"),
        ({"law": "paper"}, None, "law 'paper'.*--set 'law=\"certified\"'"),
        ({"law": ""}, None, "Is the controller running"),
        ({"mode": "stopped"}, None, "tandem resume"),
        ({"speed": 0.1}, None, "still moves at 100 mm/s"),
        ({}, None, "no answer on wrench/tare. Is wrench running"),
        ({}, NO, "wrench/tare was refused: the tool moves"),
        ({"position": np.array([0.5, -0.3, 0.7])}, YES, "300 mm from the pose"),
        ({"error_bound": 2.0}, YES, "error bound of force z is 2.00 N.*ft_noise"),
    ],
)
def test_gives_up_with_the_reason(changes: dict[str, Any], answer: dict[str, Any] | None, reason: str) -> None:
    with pytest.raises(Failed, match=reason):
        play(dataclasses.replace(AT_POSE, **changes), answer)
