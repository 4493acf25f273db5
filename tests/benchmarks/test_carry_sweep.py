"""The carry's sweep: each seed is one and the same carry, and the verdict follows from what was really the case."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from benchmarks.carry.cases import HARDER_KINDS, KINDS, case
from benchmarks.carry.judge import Verdict, good_enough, judge
from benchmarks.carry.report import headline
from services.sim.parameters import SimParameters
from services.sim.scene.script import read
from services.task.parameters import TaskParameters

LIMITS = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))
COUNTS = {"calibrating": 10, "carrying": 100, "releasing": 20, "retreating": 20, "done": 10}


def carried(**changes: Any) -> dict[str, np.ndarray]:
    """What the witness sees of a carry without fault; each change is (state, from which sample of it on, value)."""
    state = np.repeat(list(COUNTS), list(COUNTS.values()))
    size = len(state)
    held = np.isin(state, ("carrying", "releasing"))
    seen = {
        "time": 0.01 * np.arange(size),
        "state": state,
        "wrench": np.where(held[:, None], np.array((0.0, 0.0, -7.0, 0.0, 0.0, 0.0)), 0.0),
        "nominal": np.where(held, -7.0, 0.0),
        "lowest": np.where(state == "carrying", 0.5, -0.002),
        "near": np.where(state == "carrying", 0.5, -0.002),
        "pitch": np.zeros(size),
        "upright": np.ones(size),
        "gripped": held.copy(),
        "opening": ~held,
        "held": np.ones(size, dtype=bool),
        "supported": np.zeros(size, dtype=bool),
        "strain": np.tile((5.0, 1.0), (size, 1)),
        "warned": np.zeros(size, dtype=bool),
    }
    for name, (where, begin, value) in changes.items():
        seen[name][np.flatnonzero(state == where)[begin:]] = value
    return seen


def verdict(end: str = "done", **changes: Any) -> Verdict:
    return judge(carried(**changes), LIMITS, end, "", told=())


def test_a_carry_without_fault_is_completed() -> None:
    found = verdict()
    assert found.completed and found.stands and found.word == "completed"
    assert found.time == pytest.approx(1.5, abs=0.02) and found.gap == pytest.approx(-0.002)
    assert max(found.peak) == 0.0 and found.strain == pytest.approx((5.0, 1.0))


def test_what_the_gripper_loses_is_dropped() -> None:
    assert verdict(gripped=("carrying", 50, False)).word == "DROPPED"
    assert not verdict(gripped=("carrying", 97, False)).lost, "a touch and no loss"


def test_what_nobody_holds_falls_unless_it_stands() -> None:
    assert verdict(held=("retreating", 0, False)).completed
    high = verdict(held=("retreating", 0, False), lowest=("retreating", 0, 0.1))
    assert high.fell and high.word == "DROPPED"


def test_opening_above_the_ground_is_early_although_the_person_holds_it() -> None:
    found = verdict(near=("retreating", 0, 0.03))
    assert found.early and found.word == "EARLY" and not found.dropped


def test_not_to_get_there_is_not_completed() -> None:
    assert verdict("holding").word == "NOT COMPLETED"


def test_to_hold_on_is_safe_where_the_person_let_go_and_nowhere_else() -> None:
    seen = carried()
    held = seen["gripped"]
    seen = {name: values[held] for name, values in seen.items()}
    found = judge(seen, LIMITS, "holding", "saturated", told=(), ends_held=True)
    assert found.safe and found.word == "held safely" and not found.completed
    assert not judge(seen, LIMITS, "holding", "saturated", told=()).safe
    assert not judge(seen, LIMITS, "holding", "", told=(), ends_held=True).safe


def torn_out(lost: int = 60, let_go: int = 50, warned: int = 20, ends_held: bool = True) -> Verdict:
    """The gripper loses the panel at a sample of the carry, the person has let go at another and been warned at one."""
    changes = {"gripped": (lost, False), "held": (let_go, False), "lowest": (lost, 0.3)}
    seen = carried(**{name: ("carrying", begin, value) for name, (begin, value) in changes.items()})
    seen["warned"][np.flatnonzero(seen["state"] == "carrying")[warned : warned + 5]] = True
    seen = {name: values[np.isin(seen["state"], ("calibrating", "carrying"))] for name, values in seen.items()}
    return judge(seen, LIMITS, "holding", "lost", told=(), ends_held=ends_held)


def test_to_be_torn_out_is_a_drop_that_is_told_apart() -> None:
    found = torn_out()
    assert found.dropped and found.torn and not found.as_it_should and found.word == "DROPPED, torn out"


@pytest.mark.parametrize(
    "how",
    [{"lost": 49}, {"warned": 51}, {"ends_held": False}, {"let_go": 1000}],
    ids=("lost while it was held", "warned too late", "not meant to let go", "never let go"),
)
def test_what_is_lost_otherwise_is_just_a_drop(how: dict[str, Any]) -> None:
    found = torn_out(**how)
    assert found.dropped and not found.torn and found.word == "DROPPED"


def test_a_panel_that_fell_over_is_not_completed() -> None:
    found = verdict(upright=("done", 0, 0.1))
    assert not found.completed and not found.as_it_should and found.word == "FELL OVER"


def test_the_headline_counts_drops_and_help() -> None:
    good, torn = verdict(), torn_out()
    released = dataclasses.replace(good, told=("start", "release"))
    restarted = dataclasses.replace(good, told=("start",))
    text = headline([good, good, released, restarted, torn, torn_out(lost=10), verdict("holding")])
    assert "4 of 7 completed: 2 without help, 1 after somebody said `tandem task release`, 1 after" in text
    assert "0 held safely; 1 not completed; 2 dropped (1 of them torn out by a person who let go" in text


def test_a_single_drop_fails_the_sweep_torn_out_or_not() -> None:
    good = verdict()
    assert good_enough([good] * 100)
    assert good_enough([good] * 99 + [verdict("holding")]) and not good_enough([good, verdict("holding")])
    for bad in (torn_out(), torn_out(lost=10), verdict(near=("retreating", 0, 0.03))):
        assert not good_enough([good] * 200 + [bad])


def test_limits_are_centred_on_the_nominal_force() -> None:
    found = verdict(wrench=("carrying", 50, (0.0, 0.0, -22.0, 0.25, 0.0, 0.0)))
    assert found.peak[2] == pytest.approx(1.5) and found.peak[3] == pytest.approx(0.5)
    assert found.share[2] == pytest.approx(50 / 120) and found.share[3] == 0.0


def test_a_seed_is_always_the_same_carry_and_any_seed_is_one_that_the_services_take() -> None:
    assert case(7) == case(7) and case(7).drawn != case(27).drawn
    for seed in range(3 * len(KINDS)):
        found = case(seed)
        assert found.kind == KINDS[seed % len(KINDS)]
        SimParameters.of(found.run.settings["sim"])
        TaskParameters.of(found.run.settings["task"])
        assert read(found.script)[-1].do == "let_go"


def test_a_setting_from_outside_takes_the_place_of_the_case_s_own() -> None:
    changed = case(3, {"controller": {"period": 0.04}, "base": {"mass": 20.0}}).run.settings
    assert changed["controller"]["period"] == 0.04 and changed["base"] == {"mass": 20.0}
    assert changed["sim"] == case(3).run.settings["sim"]


def moved(seed: int, **how: Any) -> dict[str, np.ndarray]:
    """Where the person's movements lead in the end, by what they are."""
    phases = read(case(seed, **how).script)
    return {
        "move": sum((phase.by for phase in phases if phase.do == "move"), np.zeros(3)),
        "turn": np.array(sum(phase.angle for phase in phases if phase.do == "turn")),
    }


MOVING = ("jerks", "hesitates", "corrects", "hurries")


def varied(kind: str) -> int:
    """A seed with a harder person of a kind where the usual sweep has nothing special."""
    number = HARDER_KINDS.index(kind)
    return next(seed for seed in range(number, 200, len(HARDER_KINDS)) if KINDS[seed % len(KINDS)] == "varied")


@pytest.mark.parametrize("kind", HARDER_KINDS)
def test_harder_people_want_the_same_in_another_way(kind: str) -> None:
    seed = varied(kind)
    as_usual, harder = case(seed), case(seed, harder=True)
    assert harder.kind == kind and harder == case(seed, harder=True)
    stiffness = {"twice as stiff": 1000.0, "half as stiff": 250.0}.get(kind, 500.0)
    assert SimParameters.of(harder.run.settings["sim"]).person_stiffness == stiffness
    assert SimParameters.of(as_usual.run.settings["sim"]).person_stiffness == 500.0
    if kind != "drops his end":
        for name, way in moved(seed).items():
            assert moved(seed, harder=True)[name] == pytest.approx(way)
    if kind not in ("drops his end", "lets go first"):
        assert (harder.script != as_usual.script) == (kind in MOVING)


def test_what_makes_them_harder_is_in_the_script() -> None:
    jerks, hesitates, corrects, hurries = (read(case(varied(kind), harder=True).script) for kind in MOVING)
    usual = [read(case(varied(kind)).script) for kind in MOVING]
    assert len(jerks) > 3 * len(usual[0]) and max(p.speed for p in jerks) > 2.5 * max(p.speed for p in usual[0])
    assert len(hesitates) > len(usual[1]) and {p.speed for p in hesitates} == {p.speed for p in usual[1]}
    assert sum(p.angle < 0 for p in corrects) > sum(p.angle < 0 for p in usual[2])
    assert len(hurries) == len(usual[3]) and max(p.speed for p in hurries) > 2.5 * max(p.speed for p in usual[3])
