"""Gravity against the wrist's sensor: right axes are never doubted, wrong ones are named."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from shared.robot.bridge.gravity import AVERAGED, GravityWatch
from shared.spatial import GRAVITY, quaternion_from_rpy, rotation_from_vector, rotation_matrix

MASS = 0.82  # [kg]
angles = st.floats(-3.1, 3.1)
attitudes = st.tuples(angles, angles, angles).map(lambda rpy: rotation_matrix(quaternion_from_rpy(*rpy)))
biases = st.tuples(*[st.floats(-2.0, 2.0)] * 3).map(np.array)
LEVEL = rotation_matrix(quaternion_from_rpy(0.0, np.pi / 2, 0.0))  # the sensor's z axis points forwards


class Wrist:
    """A sensor with axes that may be wrong, held at rest in one attitude after the other."""

    def __init__(self, axes: np.ndarray, mass: float = MASS, bias: np.ndarray | None = None) -> None:
        self.watch = GravityWatch("/ft", MASS)
        self.axes, self.mass = axes, mass
        self.bias = np.zeros(3) if bias is None else bias
        self.now = 0.0

    def hold(self, attitude: np.ndarray, still: bool = True) -> str:
        down = -attitude[2]
        for _ in range(round(AVERAGED / 0.01) + 2):
            self.now += 0.01
            self.watch.hear(self.axes @ (self.mass * GRAVITY * down) + self.bias, down, still, self.now)
        self.watch.hear(np.zeros(3), down, False, self.now)
        return self.watch.line


@settings(max_examples=100, deadline=None)
@given(st.lists(attitudes, min_size=1, max_size=6), biases)
def test_a_sensor_with_the_right_axes_is_not_doubted(held: list[np.ndarray], bias: np.ndarray) -> None:
    wrist = Wrist(np.eye(3), bias=bias)
    for attitude in held:
        assert wrist.hold(attitude) == ""


@settings(max_examples=100, deadline=None)
@given(angles, st.floats(-0.5, 0.5), biases, st.floats(0.8, 2.3) | st.floats(-2.3, -0.8))
def test_axes_that_are_turned_about_the_flange_are_named_from_three_attitudes_whatever_the_bias(
    roll: float, pitch: float, bias: np.ndarray, turn: float
) -> None:
    wrist = Wrist(rotation_from_vector((0.0, 0.0, turn)), bias=bias)
    for third in range(3):
        # The flange, which points forwards and a little up or down, turns by thirds of a circle.
        turned = rotation_from_vector((0.0, 0.0, roll + third * 2.0 * np.pi / 3.0))
        line = wrist.hold(rotation_from_vector((0.0, pitch, 0.0)) @ LEVEL @ turned)
    assert f"turned by {np.degrees(turn):.0f} degrees about z" in line


@settings(max_examples=50, deadline=None)
@given(attitudes, attitudes, biases)
def test_the_opposite_sign_is_named_from_two_attitudes(first: np.ndarray, second: np.ndarray, bias: np.ndarray) -> None:
    assume(float(first[2] @ second[2]) < 0.9)
    wrist = Wrist(-np.eye(3), bias=bias)
    wrist.hold(first)
    assert "/ft: as its weight changes from posture to posture, it has the opposite sign" in wrist.hold(second)


def test_one_attitude_is_enough_for_the_tools_own_weight() -> None:
    assert "/ft: by the tool's weight, it has the opposite sign" in Wrist(-np.eye(3)).hold(LEVEL)
    turned = rotation_from_vector((0.0, 0.0, np.pi / 4))
    assert "/ft: by the tool's weight, its axes are turned by 45 degrees about z" in Wrist(turned).hold(LEVEL)


def test_a_turn_that_is_none_about_the_flange_is_told_as_what_it_is() -> None:
    wrist = Wrist(rotation_from_vector((1.2, 0.0, 0.0)))
    wrist.hold(LEVEL)
    wrist.hold(np.eye(3))
    assert "change from posture to posture as no weight" in wrist.hold(rotation_from_vector((2.0, 1.0, 0.0)))


@pytest.mark.parametrize("mass", [0.0, 0.1])
def test_what_weighs_nothing_tells_nothing(mass: float) -> None:
    wrist = Wrist(-np.eye(3), mass=mass)
    assert wrist.hold(LEVEL) == wrist.hold(np.eye(3)) == ""


def test_nothing_is_concluded_from_a_wrist_in_motion() -> None:
    assert Wrist(-np.eye(3)).hold(LEVEL, still=False) == ""


def test_what_was_found_stands_when_postures_are_forgotten_and_a_heavier_tool_is_no_contradiction() -> None:
    wrist = Wrist(np.eye(3))
    wrist.hold(LEVEL)
    wrist.watch.forget()
    wrist.mass = 3.0
    assert wrist.hold(np.eye(3)) == ""
    wrong = Wrist(-np.eye(3))
    line = wrong.hold(LEVEL)
    wrong.watch.forget()
    assert wrong.watch.line == line != ""
