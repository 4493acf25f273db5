"""Brakes are found wherever they were told, each once, and the time that they upset is left out."""

from __future__ import annotations

import numpy as np

from services.experiment.measure.brakes import NO_COMMAND, SETTLING, Brake, brakes, undisturbed
from services.experiment.play.recording import Recording
from shared.robot.side import HOLDING_AFTER

TIME = np.arange(0.0, 5.0, 0.01)


def recording(rests: dict[float, str], held_at: tuple[float, ...], held_before: int = 0) -> Recording:
    """A controller that rests at some times for a reason, and a gate that broke off motions at others."""
    state = np.full(len(TIME), "yielding", dtype="U20")
    reason = np.full(len(TIME), "", dtype="U60")
    for time, why in rests.items():
        state[np.isclose(TIME, time)], reason[np.isclose(TIME, time)] = "braking", why
    held = np.full(len(TIME), held_before)
    for time in held_at:
        held += time <= TIME
    return Recording(
        {},
        [],
        {
            "control/status": {"time": TIME, "state": state, "reason": reason},
            "state/robot": {"time": TIME[::5], "held": held[::5]},
        },
    )


def test_a_run_without_brakes_has_none_whatever_the_gate_had_counted_before() -> None:
    assert brakes(recording({}, (), held_before=7)) == []


def test_the_gates_brake_is_found_and_was_a_while_before_it_was_told() -> None:
    (brake,) = brakes(recording({}, (2.0,)))
    assert (brake.end, brake.reason) == (2.0, NO_COMMAND)
    assert np.isclose(brake.start, 2.0 - HOLDING_AFTER)


def test_the_controllers_brake_and_what_the_gate_makes_of_it_are_one() -> None:
    rests = {2.0: "wrench is 31 ms old: holding", 2.05: "wrench is 40 ms old: holding"}
    (brake,) = brakes(recording(rests, (1.95, 2.1)))
    assert brake == Brake(1.95 - HOLDING_AFTER, 2.1, "wrench is 31 ms old")


def test_brakes_that_lie_apart_are_counted_each() -> None:
    found = brakes(recording({1.0: "a", 3.0: "b"}, (2.0,)))
    assert [brake.reason for brake in found] == ["a", NO_COMMAND, "b"]


def test_a_brake_upsets_the_load_until_it_has_settled() -> None:
    quiet = undisturbed(TIME, [Brake(1.0, 1.2, "a"), Brake(3.0, 3.0, "b")])
    upset = ((TIME >= 1.0) & (TIME < 1.2 + SETTLING)) | ((TIME >= 3.0) & (TIME < 3.0 + SETTLING))
    np.testing.assert_array_equal(quiet, ~upset)
    assert undisturbed(TIME, []).all()
