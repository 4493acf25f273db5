"""A service begins to work, and begins again, only after its inputs were healthy for the start-up time."""

from __future__ import annotations

import pytest

from shared import faults
from shared.clock import nanoseconds
from shared.faults import FaultKind
from shared.loop.arming import REARM_AFTER, Arming

STARTUP = 0.5
BROKEN = faults.silent("sensor/ft", "robot", 1.0, 0.03)


def kinds(arming: Arming, *judged: tuple[float, bool]) -> list[FaultKind | None]:
    """What is judged at some times [s], healthy or not."""
    answers = [arming.judge(nanoseconds(at), None if healthy else BROKEN) for at, healthy in judged]
    return [None if answer is None else answer.kind for answer in answers]


def armed() -> Arming:
    arming = Arming(0, STARTUP, needed=True)
    assert kinds(arming, (0.0, True), (STARTUP, True))[-1] is None
    return arming


def test_healthy_inputs_have_to_last() -> None:
    arming = Arming(0, STARTUP, needed=True)
    assert kinds(arming, (0.0, False), (1.0, True), (1.49, True), (1.5, True)) == [
        FaultKind.SILENT,
        FaultKind.ARMING,
        FaultKind.ARMING,
        None,
    ]


def test_a_fault_begins_the_start_up_again() -> None:
    arming = Arming(0, STARTUP, needed=True)
    assert kinds(arming, (0.0, True), (0.4, False), (0.41, True), (0.9, True))[-1] is FaultKind.ARMING


@pytest.mark.parametrize(("lasts", "answer"), [(0.5 * REARM_AFTER, None), (1.5 * REARM_AFTER, FaultKind.ARMING)])
def test_only_a_lasting_fault_needs_a_new_start_up(lasts: float, answer: FaultKind | None) -> None:
    assert kinds(armed(), (1.0, False), (1.0 + lasts, False), (1.01 + lasts, True))[-1] is answer


def test_another_session_needs_a_new_start_up() -> None:
    arming = armed()
    arming.restart()
    assert kinds(arming, (1.0, True), (1.0 + STARTUP, True)) == [FaultKind.ARMING, None]


def test_without_required_inputs_there_is_nothing_to_wait_for() -> None:
    arming = Arming(0, STARTUP, needed=False)
    arming.restart()
    assert kinds(arming, (0.0, True)) == [None]
