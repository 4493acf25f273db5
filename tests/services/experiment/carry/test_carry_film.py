"""What the film of a carry is told: on one time base, in plain words, with the moments that matter."""

from __future__ import annotations

import numpy as np
import pytest

from services.experiment.carry import carry_film as story
from services.experiment.carry.carry_course import AFTERWARDS
from services.experiment.carry.carry_film import Story, film_data
from services.experiment.play.recording import Recording
from shared.spatial import quaternion_from_vector

END = 50.0
SCRIPT = (
    # From [s], state, doing.
    (-5.0, "idle", ""),
    (1.0, "searching", "wait"),
    (3.0, "approaching", "wait"),
    (8.0, "grasping", "wait"),
    (10.0, "carrying", "take_hold"),
    (11.0, "carrying", "lift"),
    (14.0, "carrying", "move"),
    (26.0, "carrying", "turn"),
    (36.0, "carrying", "lower"),
    (42.0, "releasing", "wait"),
    (44.0, "retreating", "let_go"),
    (46.0, "done", ""),
)
FIRST = np.array([begin for begin, _, _ in SCRIPT])


def told(time: np.ndarray, column: int) -> np.ndarray:
    return np.array([SCRIPT[row][column] for row in np.searchsorted(FIRST, time, side="right") - 1])


def hands(time: np.ndarray) -> np.ndarray:
    """Pulled by 0.5 m, pushed back by 0.3 m, and to the left by 0.4 m."""
    along = np.interp(time, (14.0, 18.0, 21.0), (0.0, 0.5, 0.2))
    aside = np.interp(time, (21.0, 25.0), (0.0, 0.4))
    return np.column_stack((1.7 + along, aside - 0.4, np.full(len(time), 0.9)))


def turned(time: np.ndarray) -> np.ndarray:
    """Twisted by 20 degrees and back, then turned upright."""
    angles = np.radians(np.interp(time, (26.0, 28.0, 30.0, 31.0, 35.0), (0.0, 20.0, 0.0, 0.0, 90.0)))
    return np.array([quaternion_from_vector((angle, 0.0, 0.0)) for angle in angles])


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_film_data_are_on_one_time_base(carried: Recording) -> None:
    data = film_data(carried)
    time = data["time"]
    assert 0.0 <= time[0] < 0.04 and data["scene"] == "carry"
    single = {"scene", "parameters", "joint_names", "moment_times", "moment_captions"}
    assert {len(column) for name, column in data.items() if name not in single} == {len(time)}
    row = int(np.searchsorted(time, 30.0))
    wrench = carried.newest("wrench/external", time, "force", "torque")[row]
    nominal = carried.newest("control/target", time, "nominal_force", "nominal_torque")[row]
    assert nominal[2] < -5.0 and data["wrench"][row] == pytest.approx(wrench - nominal)
    asked = carried.time("control/target")[0]
    assert asked > time[0] and np.array_equal(np.isnan(data["limit"]).all(axis=1), time < asked)
    events = {event.name: event.time for event in carried.events}
    assert time[data["covered"]][0] == pytest.approx(events["covered"], abs=0.05)
    looked = (events.get("calibrating", events["searching"]), events["grasping"])
    assert time[data["looking"]][[0, -1]] == pytest.approx(looked, abs=0.25)
    held = (events["person: take_hold"], events["end"] - AFTERWARDS)
    assert time[data["person_holds"]][[0, -1]] == pytest.approx(held, abs=0.25)


def a_story(end: float = END) -> Story:
    time = np.arange(0.0, end, 0.05)
    return Story(time, told(time, 1), told(time, 2), hands(time), turned(time))


def test_the_moments_tell_the_whole_carry() -> None:
    captions = [caption for _, caption in a_story().moments]
    assert captions == [
        "marker found",
        "grasped",
        "lifted",
        "pulled",
        "led sideways",
        "twisted",
        "turned upright",
        "set down",
    ]
    times = [time for time, _ in a_story().moments]
    assert times == pytest.approx([3.0, 10.0, 14.0, 18.0, 25.0, 28.0, 36.0, END], abs=0.11)


def test_of_a_carry_that_was_given_up_the_moments_are_those_that_came() -> None:
    assert [caption for _, caption in a_story(12.0).moments] == ["marker found", "grasped", "lifted"]
    assert a_story(2.0).moments == []


@pytest.mark.parametrize(
    ("time", "caption"),
    [
        (2.0, story.STATES["searching"]),
        (12.0, story.DOINGS["lift"]),
        (16.0, story.PULLS),
        (19.5, story.PUSHES),
        (23.0, story.SIDEWAYS),
        (25.7, story.SIDEWAYS),
        (28.0, story.TWISTS),
        (33.0, story.TURNS),
        (43.0, story.STATES["releasing"]),
    ],
)
def test_captions_say_what_happens(time: float, caption: str) -> None:
    assert a_story().captions[round(time / 0.05)] == caption


def test_no_state_of_the_task_goes_without_words() -> None:
    from services.task.states import State

    assert set(story.STATES) == {state.value for state in State}
