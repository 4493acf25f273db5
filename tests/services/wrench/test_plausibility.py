"""What cannot be the zero of a free tool is refused; what can be never is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from services.wrench.averaging import Average
from services.wrench.compensation import Compensation
from services.wrench.identification import identify
from services.wrench.plausibility import Declared, Former, forced, payload_doubt, tare_doubt
from shared.spatial import Array, rotation_from_vector
from tests.services.wrench.sensor import LEVEL, TILTED, TOOL_OFFSET, Sensor

BIAS_BOUND = np.array((3.0, 3.0, 3.0, 0.3, 0.3, 0.3))
DECLARED = Declared(BIAS_BOUND, 0.83, 0.1, TOOL_OFFSET, 0.0)
ERROR = np.array((0.05, 0.05, 0.05, 0.002, 0.002, 0.002))
NOTHING = Compensation()

turns = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(rotation_from_vector)
inside = st.tuples(*[st.floats(-1.0, 1.0)] * 6).map(np.array)
balls = inside.map(lambda v: v[:3] / max(1.0, float(np.linalg.norm(v[:3]))))


def average(mean: Array, rotation: Array = LEVEL) -> Average:
    return Average(mean, 0.1 * ERROR, 100, rotation)


def tool(mass: float = 0.8, away: Array | None = None, bias: Array | None = None) -> Sensor:
    return Sensor(mass, TOOL_OFFSET + (np.zeros(3) if away is None else away), np.zeros(6) if bias is None else bias)


@given(turn=turns, mass=st.floats(0.0, 0.83), away=balls, bias=inside)
def test_a_free_tool_as_declared_is_never_doubted(turn: Array, mass: float, away: Array, bias: Array) -> None:
    sensor = tool(mass, 0.1 * away, bias * BIAS_BOUND)
    assert tare_doubt(average(sensor.exact(turn), turn), NOTHING, DECLARED, None) == ""


@given(turn=turns, mass=st.floats(0.0, 0.83), touch=inside)
def test_whatever_lies_beyond_bias_and_weight_is_refused(turn: Array, mass: float, touch: Array) -> None:
    """No mass, no bias: farther from every possible weight than the bias bound's corner is a touch for sure."""
    sensor, touch = tool(mass), 40.0 * touch * (1, 1, 1, 0, 0, 0)
    reading = sensor.exact(turn, touch)
    masses = np.linspace(0.0, 0.83, 200)[:, None]
    nearest = np.abs(reading[:3] + masses * 9.81 * turn[2]).max(axis=1).min()
    assume(nearest > 3.2)
    assert "Does something touch the tool" in tare_doubt(average(reading, turn), NOTHING, DECLARED, None)


TOUCHES = {
    "20 N sideways": (20, 0, 0, 0, 0, 0),
    "40 N hang": (0, 0, -40, 0, 0, 0),
    "15 N with 8 Nm": (0, 15, 0, 8, 0, 0),
    "a torque alone": (0, 0, 0, 0, 0, 2.0),
    "lifted": (0, 0, 15, 0, 0, 0),
}


@pytest.mark.parametrize("name", TOUCHES)
@pytest.mark.parametrize("known", ["nothing", "payload"])
def test_touches_that_a_steady_average_does_not_show(name: str, known: str) -> None:
    sensor = tool()
    payload = Compensation("payload", mass=0.8, moment=0.8 * TOOL_OFFSET)
    reading = average(sensor.exact(LEVEL, np.array(TOUCHES[name], dtype=float)))
    doubt = tare_doubt(reading, payload if known == "payload" else NOTHING, DECLARED, None)
    assert "unexplained" in doubt and "\n" not in doubt


def test_the_opposite_sign_is_the_first_cause_where_the_weight_shows_it() -> None:
    sensor = tool(bias=0.5 * BIAS_BOUND)
    doubt = tare_doubt(average(-sensor.exact(LEVEL)), NOTHING, DECLARED, None)
    assert "unexplained. Are the readings of the opposite sign" in doubt


@given(
    turn=turns, then=turns, drift=inside, touch=st.sampled_from([0.0, 4.0]), kind=st.sampled_from(["tare", "payload"])
)
@settings(max_examples=60)
def test_the_former_zero_tells_a_touch_from_a_bias(
    turn: Array, then: Array, drift: Array, touch: float, kind: str
) -> None:
    """Within the bias bound, too; and drift and another attitude of the same tool are no touch."""
    sensor, bound = tool(), replace(DECLARED, bias_bound=10 * BIAS_BOUND)
    zero = Compensation("tare", bias=sensor.exact(then), up=then[2])
    if kind == "payload":
        zero = Compensation("payload", mass=0.8, moment=0.8 * TOOL_OFFSET)
    former = Former(zero, 10 * ERROR, 300.0)
    here = turn if kind == "payload" else then
    reading = sensor.exact(here) + 9 * ERROR * drift
    reading[:3] += touch
    doubt = tare_doubt(average(reading, here), zero if kind == "payload" else NOTHING, bound, former)
    assert bool(doubt) == bool(touch)
    assert not doubt or "from the zero of 300 s ago" in doubt
    if kind == "tare":
        assert tare_doubt(average(sensor.exact(turn), turn), NOTHING, bound, former) == ""


def test_what_is_forced_widens_the_declared_bounds_that_it_refutes() -> None:
    sensor = tool(2.0)
    reading = average(sensor.exact(LEVEL))
    tared = NOTHING.tared(reading.mean, reading.mean_error, reading.noise, LEVEL)
    assert forced(tared, "", DECLARED) is tared
    adopted = forced(tared, "heavy", DECLARED)
    assert adopted.warning == "heavy"
    assert adopted.tool_mass == pytest.approx(2.0) and adopted.bias_bound[2] == pytest.approx(2.0 * 9.81)
    later = tared.replaced(bias=tared.bias + 2.0 * np.eye(6)[0])
    drifted = forced(later, "moved", DECLARED, Former(tared, ERROR, 120.0))
    assert drifted.drift[0] == pytest.approx(1.0, abs=0.1)
    moved = tared.replaced(bias=tared.bias + 20.0)
    assert not forced(moved, "moved", DECLARED, Former(tared, ERROR, 120.0)).drift.any(), "no zero drifts that far"
    assert later.tared(reading.mean, reading.mean_error, reading.noise, LEVEL).warning == ""


IMPOSSIBLE = {
    "heavy": (tool(1.2), "kg were found"),
    "far": (tool(away=np.array((0.2, 0.0, 0.0))), "tool_reach declares"),
    "biased": (tool(bias=np.array((0.0, 6.0, 0, 0, 0, 0))), "a bias of 6 N was found in force y"),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_payloads_that_are_not_possible(name: str) -> None:
    sensor, words = IMPOSSIBLE[name]
    result = identify([average(sensor.exact(rotation), rotation) for rotation in TILTED])
    assert words in payload_doubt(result, DECLARED, None)


def test_torques_of_the_opposite_sign_are_told_by_their_lever() -> None:
    flipped = [average(tool().exact(rotation) * (1, 1, 1, -1, -1, -1), rotation) for rotation in TILTED]
    assert "Are the torques of the opposite sign?" in payload_doubt(identify(flipped), DECLARED, None)


def test_a_payload_is_held_against_the_tare_before_it() -> None:
    sensor = tool()
    result = identify([average(sensor.exact(rotation), rotation) for rotation in TILTED])
    former = lambda offset: Former(Compensation("tare", sensor.exact(LEVEL) + offset, up=LEVEL[2]), ERROR, 60.0)  # noqa: E731
    assert payload_doubt(result, DECLARED, former(0.0)) == ""
    assert "from the zero of 60 s ago" in payload_doubt(result, DECLARED, former(2.0))
