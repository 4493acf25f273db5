"""When to let go: both stages, each condition, noise; pose or force alone is never enough."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.task.release import ReleaseJudge, Stance, why_no_probe, why_no_release
from services.task.timers import LeakyTimer, Sustained

DT = 0.02
STANDING = Stance(roll=math.pi / 2, pitch=0.0, height=0.0, speed=0.0, turning=0.0, force=0.0)


def probes(stance: Stance, duration: float = 2.0) -> bool:
    judge = ReleaseJudge()
    return any([judge.may_probe(stance, DT) for _ in range(round(duration / DT))])


def releases(stance: Stance, duration: float = 5.0, **how: bool) -> bool:
    judge = ReleaseJudge()
    return any([judge.may_release(stance, DT, **how) for _ in range(round(duration / DT))])


def test_a_panel_that_stands_is_probed_then_released() -> None:
    assert probes(STANDING) and releases(STANDING)
    assert not probes(STANDING, 0.48) and not releases(STANDING, 0.96)
    assert probes(replace(STANDING, roll=-math.pi / 2)), "to the other side as well"


NOT_PROBED = {
    "not turned": {"roll": 0.0},
    "not turned far enough": {"roll": math.radians(74)},
    "turned too far": {"roll": math.radians(106)},
    "too high": {"height": 0.06},
    "far end up": {"pitch": math.radians(-7.5)},
    "far end far down": {"pitch": math.radians(20.5)},
    "moving": {"speed": 0.04},
    "turning": {"turning": 0.04},
}


@pytest.mark.parametrize("name", NOT_PROBED)
def test_every_condition_of_the_probe_counts(name: str) -> None:
    stance = replace(STANDING, **NOT_PROBED[name])
    assert not probes(stance) and len(why_no_probe(stance)) == 1


NOT_RELEASED = {
    "not turned": {"roll": math.radians(70)},
    "too high": {"height": 0.065},
    "far end up": {"pitch": math.radians(-6.5)},
    "far end far down": {"pitch": math.radians(20.5)},
    "carried by the robot": {"force": -3.0},
}


@pytest.mark.parametrize("name", NOT_RELEASED)
def test_every_condition_of_the_release_counts(name: str) -> None:
    stance = replace(STANDING, **NOT_RELEASED[name])
    assert not releases(stance) and len(why_no_release(stance, stance.force)) == 1


def test_a_tool_that_points_down_does_not_keep_a_panel_that_stands() -> None:
    """The panel turned between the fingers: the tool's height says that its near end is down."""
    assert probes(replace(STANDING, pitch=math.radians(12))) and releases(replace(STANDING, pitch=math.radians(12)))


def test_a_person_s_word_replaces_the_pose_but_not_the_force() -> None:
    lying = replace(STANDING, roll=0.0, height=0.5)
    assert releases(lying, pose_matters=False)
    assert not releases(replace(lying, force=-7.0), pose_matters=False)


@given(st.integers(0, 2**32 - 1))
def test_no_single_sample_lets_go(seed: int) -> None:
    """A panel of 7 N in the air: force peaks to zero."""
    random = np.random.default_rng(seed)
    judge = ReleaseJudge()
    for _ in range(500):
        peak = random.random() < 0.3
        stance = replace(STANDING, force=0.0 if peak else -7.0 + random.normal(0.0, 1.0))
        assert not judge.may_release(stance, DT)


def test_a_weight_that_shakes_is_judged_by_its_mean() -> None:
    """More than half of the samples alone would say that the ground carries it."""
    judge = ReleaseJudge()
    for step in range(1000):
        force = -12.0 if step % 3 == 2 else 0.0
        assert not judge.may_release(replace(STANDING, force=force), DT)


def test_noise_on_a_standing_panel_delays_and_does_not_block() -> None:
    random = np.random.default_rng(3)
    judge = ReleaseJudge()
    times = [
        step * DT
        for step in range(500)
        if judge.may_release(replace(STANDING, pitch=random.normal(0.0, math.radians(4.0)), force=-1.0), DT)
    ]
    assert times and 0.98 <= times[0] < 6.0


def test_leaving_and_pressing() -> None:
    judge = ReleaseJudge()
    assert not judge.has_to_leave(STANDING)
    assert judge.has_to_leave(replace(STANDING, roll=math.radians(66)))
    assert judge.has_to_leave(replace(STANDING, height=0.085))
    for _ in range(50):
        judge.may_release(replace(STANDING, force=-5.0), DT)
    assert judge.press() == 0.01
    for _ in range(50):
        judge.may_release(replace(STANDING, force=-0.5), DT)
    assert judge.press() == 0.0


@given(st.lists(st.booleans(), max_size=200))
def test_held_needs_an_unbroken_while(conditions: list[bool]) -> None:
    held, run = Sustained(0.1), 0
    for condition in conditions:
        run = run + 1 if condition else 0
        assert held.update(condition, DT) == (run * DT >= 0.1 - 1e-9) or abs(run * DT - 0.1) < 1e-9


@given(st.lists(st.booleans(), max_size=200))
def test_leaky_needs_as_much_more_true_than_false(conditions: list[bool]) -> None:
    leaky, balance = LeakyTimer(0.2), 0.0
    for condition in conditions:
        balance = min(0.2, max(0.0, balance + (DT if condition else -DT)))
        assert leaky.update(condition, DT) == (balance >= 0.2 - 1e-9)
