"""Signs, axes and reference points: each number below follows from statics alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.wrench.compensation import Compensation, payload_wrench
from shared.spatial import rotation_from_vector
from tests.services.wrench.sensor import LEVEL, TILTED, TOOL_OFFSET, Sensor, external_wrench

vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
wrenches = st.tuples(*[st.floats(-50.0, 50.0)] * 6).map(np.array)
ON_ITS_SIDE = rotation_from_vector((0.0, np.pi / 2, 0.0))


def test_a_kilogram_hanging_from_the_tool_pulls_down() -> None:
    reading = np.array((0.0, 0.0, -9.81, 0.0, 0.0, 0.0))
    wrench = external_wrench(reading, Compensation(), LEVEL, np.array((0.0, 0.0, 0.1)))
    assert wrench == pytest.approx([0, 0, -9.81, 0, 0, 0])


def test_force_is_rotated_to_base() -> None:
    # The sensor's z axis points along base x; a pull along the sensor's -z is a pull along base -x.
    reading = np.array((0.0, 0.0, -5.0, 0.0, 0.0, 0.0))
    wrench = external_wrench(reading, Compensation(), ON_ITS_SIDE, np.zeros(3))
    assert wrench == pytest.approx([-5, 0, 0, 0, 0, 0])


def test_torque_is_taken_about_the_tool() -> None:
    # A push of 10 N along y at the tool, 0.2 m out along z, twists the sensor by -2 Nm about x and the tool not at all.
    reading = np.array((0.0, 10.0, 0.0, -2.0, 0.0, 0.0))
    wrench = external_wrench(reading, Compensation(), LEVEL, np.array((0.0, 0.0, 0.2)))
    assert wrench == pytest.approx([0, 10, 0, 0, 0, 0])


def test_weight_of_a_mass_out_along_x() -> None:
    # 1 kg, 0.1 m out along x: 9.81 N down and, by the right hand, +0.981 Nm about y (x cross -z is +y).
    assert payload_wrench(1.0, np.array((0.1, 0.0, 0.0)), LEVEL) == pytest.approx([0, 0, -9.81, 0, 0.981, 0])


def test_none_subtracts_nothing() -> None:
    assert Compensation().offset(ON_ITS_SIDE) == pytest.approx(np.zeros(6))


@given(turn=vectors, external=wrenches)
def test_known_payload_leaves_exactly_what_the_environment_exerts(turn: np.ndarray, external: np.ndarray) -> None:
    sensor, rotation = Sensor(), rotation_from_vector(turn)
    known = Compensation("payload", bias=sensor.bias, mass=sensor.mass, moment=sensor.mass * sensor.com)
    assert external_wrench(sensor.exact(rotation, external), known, rotation, TOOL_OFFSET) == pytest.approx(
        external, abs=1e-9
    )


@given(turn=vectors, external=wrenches, heading=st.floats(-3.0, 3.0))
def test_tare_is_exact_where_it_was_made_and_under_any_heading(
    turn: np.ndarray, external: np.ndarray, heading: float
) -> None:
    sensor, rotation = Sensor(), rotation_from_vector(turn)
    tared = Compensation().tared(sensor.exact(rotation), np.zeros(6), np.zeros(6), rotation)
    assert tared.kind == "tare"
    now = rotation_from_vector((0.0, 0.0, heading)) @ rotation
    assert external_wrench(sensor.exact(now, external), tared, now, TOOL_OFFSET) == pytest.approx(external, abs=1e-9)


def test_tare_keeps_an_identified_payload_and_measures_the_bias_anew() -> None:
    sensor = Sensor()
    known = Compensation("payload", bias=np.zeros(6), mass=sensor.mass, moment=sensor.mass * sensor.com)
    tared = known.tared(sensor.exact(TILTED[1]), np.zeros(6), np.zeros(6), TILTED[1])
    assert tared.kind == "payload"
    assert tared.bias == pytest.approx(sensor.bias)
    wrench = external_wrench(sensor.exact(ON_ITS_SIDE), tared, ON_ITS_SIDE, TOOL_OFFSET)
    assert wrench == pytest.approx(np.zeros(6), abs=1e-9)
