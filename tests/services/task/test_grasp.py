"""A grasp is verified by width, effort and the gripper's word together, and home is taken a second later."""

from __future__ import annotations

import pytest

from services.task.grasp import GraspWatch, grasp_doubts
from services.task.parameters import TaskParameters
from shared.messages import GripperState

HOLDS = GripperState(0.052, 12.0, True)
DT = 0.02


@pytest.mark.parametrize(
    ("gripper", "words"),
    [
        (HOLDS, []),
        (None, ["silent"]),
        (GripperState(0.052, -12.0, True), []),
        (GripperState(0.003, 12.0, True), ["3 mm wide"]),
        (GripperState(0.052, 0.5, True), ["effort"]),
        (GripperState(0.052, 12.0, False), ["holds nothing"]),
        (GripperState(0.0, 0.0, False), ["wide", "effort", "nothing"]),
    ],
)
def test_doubts(gripper: GripperState | None, words: list[str]) -> None:
    reasons = grasp_doubts(gripper, TaskParameters(grasp_width=0.01))
    assert len(reasons) == len(words)
    assert all(word in reason for word, reason in zip(words, reasons, strict=True))


def test_settled_a_second_after_it_is_verified() -> None:
    watch = GraspWatch()
    times = [step * DT for step in range(200) if watch.settled([], DT)]
    assert times[0] == pytest.approx(1.3, abs=0.05)


def test_one_doubt_begins_anew() -> None:
    watch = GraspWatch()
    for _ in range(60):
        assert not watch.settled([], DT)
    watch.settled(["slips"], DT)
    assert not any([watch.settled([], DT) for _ in range(60)])


def test_slipped_by_the_gripper_s_word_for_a_while() -> None:
    watch = GraspWatch()
    empty = GripperState(0.05, 0.0, False)
    assert not watch.slipped(empty, DT)
    assert not any([watch.slipped(HOLDS, DT) or watch.slipped(None, DT) for _ in range(100)])
    assert any([watch.slipped(empty, DT) for _ in range(20)])
    assert watch.slipped(None, DT), "what was lost is not found by silence"
    assert not watch.slipped(HOLDS, DT)
