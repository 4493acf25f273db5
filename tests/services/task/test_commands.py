"""What a person may ask of the task: done, or refused with what to do instead."""

from __future__ import annotations

import pytest

from services.task.faults import TaskFault
from services.task.states import State
from shared.parameters import Refused
from tests.services.task.play import Play

REFUSED = {
    "unknown word": (lambda play: play.machine.command("jump"), "wanted start, abort, release or reset"),
    "no word": (lambda play: play.machine.command(None), "wanted start"),
    "start twice": (lambda play: play.reach(State.SEARCHING).machine.command("start"), "at work already"),
    "start when done": (lambda play: play.reach(State.DONE).machine.command("start"), "`reset` first"),
    "start aborted": (lambda play: play.reach(State.HOLDING).machine.command("start"), "`reset` first"),
    "reset at work": (lambda play: play.reach(State.CARRYING).machine.command("reset"), "`abort` first"),
    "release of nothing": (
        lambda play: play.reach(State.SEARCHING).machine.command("release"),
        "nothing is held",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_commands_are_refused_with_what_to_do_instead(name: str) -> None:
    act, words = REFUSED[name]
    with pytest.raises(Refused, match=words):
        act(Play())


def test_a_panel_too_narrow_for_the_arm_to_set_down_is_refused_at_the_start() -> None:
    with pytest.raises(
        Refused, match=r"stands with the gripper at 0\.25 m.*reach_down, 0\.27 m.*0\.54 m wide"
    ):
        Play(panel_width=0.5).machine.command("start")
    assert Play(panel_width=0.6).machine.command("start") is State.IDLE


def test_a_panel_too_heavy_to_be_released_is_refused_at_the_start() -> None:
    with pytest.raises(Refused, match="release_ramp"):
        Play(panel_mass=2.5, release_ramp=False).machine.command("start")
    assert Play(panel_mass=2.5).machine.command("start") is State.IDLE


def test_start_with_a_full_gripper_or_a_stop_is_refused() -> None:
    play = Play()
    play.changed = {"gripper": type(play.toy.gripper)(0.05, 10.0, True)}
    play.tick()
    with pytest.raises(Refused, match="holds something"):
        play.machine.command("start")
    play.changed, play.faults = {}, [TaskFault("stop", "hand in the way")]
    play.tick()
    with pytest.raises(Refused, match="hand in the way"):
        play.machine.command("start")


def test_carrying_on_after_an_abort_keeps_the_half_weight() -> None:
    play = Play().reach(State.CARRYING)
    play.toy.lifted = True
    play.run(2.0)
    play.machine.command("abort")
    play.run(1.0)
    with pytest.raises(Refused, match="`release` lets it go"):
        play.machine.command("reset")
    assert play.decision.nominal == pytest.approx(-play.settings.half_weight)
    play.faults = [TaskFault("wrench_silent", "3 s old")]
    play.tick()
    with pytest.raises(Refused, match="cannot carry on"):
        play.machine.command("start")
    play.faults = []
    play.tick()
    assert play.machine.command("start") is State.CARRYING
    play.tick()
    assert play.decision.base and play.decision.nominal == pytest.approx(-play.settings.half_weight)


def test_release_by_word_waits_for_the_weight_then_a_second_word_opens() -> None:
    play = Play().reach(State.CARRYING)
    play.toy.lifted = True
    play.run(2.0)
    assert play.machine.command("release") is State.RELEASING
    play.run(5.0)
    assert play.state is State.RELEASING and play.toy.gripped and "`release` again" in play.machine.reason
    play.machine.command("release")
    play.to(State.DONE)
    assert play.opened_in == {State.IDLE, State.RELEASING}
    play = Play().reach(State.CARRYING)
    play.machine.command("release")
    play.to(State.DONE)
