"""A real carry passes every claim, and each thing that can go wrong fails its own."""

from __future__ import annotations

import copy
import dataclasses
import math

import numpy as np
import pytest

from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_claims import judge
from services.experiment.carry.carry_measures import Measures, measure
from services.experiment.carry.carry_protocol import GUIDANCE, SCRIPTS
from services.experiment.play.recording import Recording
from services.sim.scene.script import read
from tests.services.experiment.carry import defects
from tests.services.experiment.carry.defects import Defect, add

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

NAME = "certified-omni"
WRENCH, WORLD = "wrench/external", "sim/world"


def failed(found: Measures, name: str = NAME) -> list[str]:
    claims = judge({name: CARRY.run_named(name)}, {name: found})
    assert claims
    return [claim.short for claim in claims if not claim.passed]


def spoilt(carried: Recording, defect: Defect) -> Recording:
    recording = copy.deepcopy(carried)
    defect(recording)
    return recording


class TestCarry:
    def test_a_good_one_passes_every_claim(self, carried: Recording) -> None:
        assert failed(measure(carried)) == []

    def test_messages_that_arrive_in_bunches_are_no_fall(self, carried: Recording) -> None:
        recording = copy.deepcopy(carried)
        world = recording.topics[WORLD]
        late = np.ceil(world["time"] / 0.15) * 0.15
        world["time"] = late + 1e-4 * np.arange(len(late))
        assert "never drops the panel" not in failed(measure(recording))

    @pytest.mark.parametrize(
        ("defect", "claims"),
        [
            *(
                (defect, {"asks for the stated limits"})
                for defect in (defects.asks_for_more, defects.centred_too_low, defects.centred_aside)
            ),
            (defects.lost, {"never drops the panel", "lets go when the ground carries it"}),
            (defects.slipped_unseen, {"never drops the panel"}),
            (defects.let_go_early, {"never drops the panel", "lets go when the ground carries it"}),
            (defects.let_go_above, {"lets go when the ground carries it"}),
            (defects.let_go_loaded, {"lets go when the ground carries it"}),
            (
                defects.never_let_go,
                {"lets go when the ground carries it", "lets go when it stands upright", "it stays where it was put"},
            ),
            (defects.stuck, {"every state and phase in order", "never drops the panel"}),
            (defects.tilted, {"keeps it level"}),
            (defects.not_turned, {"turns where it is wanted", "lets go when it stands upright"}),
            (defects.held_back, {"far end gets where it is wanted", "robot's end follows push and pull"}),
            (
                defects.base_stands,
                {
                    "far end gets where it is wanted",
                    "robot's end follows push and pull",
                    "base goes along",
                    "base keeps up",
                    "comes along sideways",
                },
            ),
            (defects.swings, {"comes along sideways"}),
            (defects.slips_round, {"robot's end follows the turns"}),
            (defects.answers_late, {"reacts to push and pull", "robot's end keeps up", "base keeps up"}),
            (defects.topples, {"it stays where it was put"}),
            (defects.pushed_away, {"it stays where it was put"}),
            (add(WORLD, "hand.force", (30.0, 0.0, 0.0), 20.0, 20.2), {"person's hands: peak force"}),
            (
                add(WRENCH, "force", (0.0, 12.0, 0.0), 0.0, np.inf),
                {"at rest: within every limit", "seldom over a limit"},
            ),
            (add(WRENCH, "torque", (1.5, 0.0, 0.0), 43.0, 45.0), {"hardly ever over 1.5 limits"}),
        ],
        ids=lambda value: getattr(value, "__name__", None) if callable(value) else "",
    )
    def test_a_defect_fails_its_claim(self, carried: Recording, defect: Defect, claims: set[str]) -> None:
        assert claims <= set(failed(measure(spoilt(carried, defect))))

    def test_what_brakes_bring_is_told_and_left_out_but_not_if_it_is_much(self, carried: Recording) -> None:
        found = measure(spoilt(carried, defects.brakes(0.05)))
        assert failed(found) == []
        assert len(found.brakes) == 8 and found.excess.braked_peak > 1.9
        often = measure(spoilt(carried, defects.brakes(0.4)))
        assert failed(often) == ["hardly ever over 1.5 limits"]

    def test_to_rest_for_a_moment_shows_nothing(self, carried: Recording) -> None:
        found = measure(carried)
        for resting, failing in ((3.1, []), (2.9, ["at rest: within every limit"])):
            excess = dataclasses.replace(found.excess, resting=resting)
            assert failed(dataclasses.replace(found, excess=excess)) == failing

    def test_the_panel_may_be_let_go_of_in_releasing_and_retreating_only(self, carried: Recording) -> None:
        found = measure(carried)
        for state in ("carrying", "holding", "grasping"):
            assert failed(dataclasses.replace(found, let_go_in=state)) == ["never drops the panel"]
        for state in ("releasing", "retreating"):
            assert failed(dataclasses.replace(found, let_go_in=state)) == []

    def test_every_law_has_to_be_asked_for_the_stated_limits(self, carried: Recording) -> None:
        found = measure(spoilt(carried, defects.asks_for_more))
        for law in ("certified", "paper", "stiffness"):
            assert "asks for the stated limits" in failed(found, f"{law}-omni")

    def test_a_baseline_that_keeps_its_limits_fails_the_claim_that_it_does_not(self, carried: Recording) -> None:
        assert failed(measure(carried), "stiffness-omni") == ["baseline: breaks its limits"]

    def test_the_comparison_follows_the_figures_not_the_names(self, carried: Recording) -> None:
        found = measure(carried)
        names = ("certified-omni", "paper-omni")
        for factor, passed in ((0.5, True), (1.5, False)):
            excess = dataclasses.replace(
                found.excess, over=factor * found.excess.over, peaks=tuple(factor * peak for peak in found.excess.peaks)
            )
            effort = dataclasses.replace(
                found.effort, force=factor * found.effort.force, guiding=factor * found.effort.guiding
            )
            other = dataclasses.replace(found, excess=excess, effort=effort)
            claims = judge(
                {name: CARRY.run_named(name) for name in names}, dict(zip(names, (other, found), strict=True))
            )
            assert [claim.passed for claim in claims if claim.run == ", ".join(names)] == [passed] * 4

    def test_what_the_motion_allows_is_no_claim_but_its_share_is_told(self, carried: Recording) -> None:
        assert measure(carried).excess.used < 0.5
        kicked = spoilt(carried, add(WRENCH, "force", (0.0, 90.0, 0.0), 37.0, 37.1))
        assert measure(kicked).excess.used > 1.0

    def test_going_back_from_releasing_to_carrying_is_allowed(self, carried: Recording) -> None:
        found = measure(carried)
        states = [*found.states]
        states[6:6] = [("releasing", 50.0), ("carrying", 51.0)]
        assert failed(dataclasses.replace(found, states=tuple(states))) == []

    def test_fingers_that_touch_the_panel_before_they_hold_it_have_not_dropped_it(self, carried: Recording) -> None:
        assert failed(measure(spoilt(carried, defects.touched_before))) == []

    def test_a_carry_that_was_broken_off_is_refused_by_name(self, carried: Recording) -> None:
        short = copy.deepcopy(carried)
        short.events = [event for event in short.events if event.name != "end"]
        with pytest.raises(ValueError, match=r"certified-omni.*'end'"):
            measure(short)

    def test_a_panel_that_was_never_grasped_is_refused_with_the_task_s_reason(self, carried: Recording) -> None:
        empty = copy.deepcopy(carried)
        empty.topics["state/gripper"]["holding"][:] = False
        with pytest.raises(ValueError, match=r"never held the panel; the task was done"):
            measure(empty)


@pytest.mark.parametrize("base", SCRIPTS)
def test_the_judge_knows_what_the_person_wants(base: str) -> None:
    """What the scripts say, with moves along and across the panel, and turns about its long axis."""
    wanted = []
    for phase in read(SCRIPTS[base]):
        if phase.do == "move":
            along, across, up = phase.by
            assert up == 0.0
            assert 0.0 in (along, across)
            wanted.append(("along", along) if along else ("across", across))
        elif phase.do == "turn":
            assert phase.about == "x"
            wanted.append(("roll", math.radians(phase.angle)))
    assert [(one.way, one.amount) for one in GUIDANCE[base]] == [(way, pytest.approx(amount)) for way, amount in wanted]
