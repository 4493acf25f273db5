"""Spatial algebra against scipy's independent implementation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from shared import spatial

TIGHT = {"atol": 1e-9, "rtol": 1e-9}
number = st.floats(-5, 5)
vector = st.tuples(number, number, number)
unit_quaternion = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: math.hypot(*q) > 1e-3)
    .map(lambda q: np.array(q) / math.hypot(*q))
)


def same_rotation(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(a if a @ b > 0 else -a, b, **TIGHT)


@given(unit_quaternion, st.floats(0.1, 10))
def test_rotation_matrix(q: np.ndarray, scale: float) -> None:
    np.testing.assert_allclose(spatial.rotation_matrix(q * scale), Rotation.from_quat(q).as_matrix(), **TIGHT)


@given(unit_quaternion)
def test_quaternion(q: np.ndarray) -> None:
    found = spatial.quaternion(Rotation.from_quat(q).as_matrix())
    assert found[3] >= 0.0 and np.linalg.norm(found) == pytest.approx(1.0, abs=1e-12)
    same_rotation(found, q)


@given(vector)
def test_rotation_from_vector(theta: tuple[float, ...]) -> None:
    expected = Rotation.from_rotvec(theta)
    np.testing.assert_allclose(spatial.rotation_from_vector(theta), expected.as_matrix(), **TIGHT)
    same_rotation(spatial.quaternion_from_vector(theta), expected.as_quat())


@settings(max_examples=300)
@given(vector, st.sampled_from((0.0, 1e-300, 1e-12, 1e-8, 1e-7, 1e-6, 1e-3, 1.0, math.pi - 1e-3, math.pi - 1e-7)))
def test_rotation_vector_at_every_angle(axis: tuple[float, ...], angle: float) -> None:
    norm = math.hypot(*axis)
    theta = np.array(axis) / norm * angle if norm > 1e-3 else np.array((angle, 0.0, 0.0))
    found = spatial.rotation_vector(Rotation.from_rotvec(theta).as_matrix())
    np.testing.assert_allclose(found, theta, atol=2e-8)


@given(unit_quaternion)
def test_logarithm_and_exponential_are_inverse(q: np.ndarray) -> None:
    rotation = Rotation.from_quat(q).as_matrix()
    theta = spatial.rotation_vector(rotation)
    assert np.linalg.norm(theta) <= math.pi + 1e-12
    np.testing.assert_allclose(spatial.rotation_from_vector(theta), rotation, atol=1e-7)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (-1, 2, 0.5)])
def test_half_turns(axis: tuple[float, ...]) -> None:
    theta = np.array(axis) / np.linalg.norm(axis) * math.pi
    found = spatial.rotation_vector(Rotation.from_rotvec(theta).as_matrix())
    assert np.linalg.norm(found) == pytest.approx(math.pi)
    np.testing.assert_allclose(abs(found @ theta), math.pi**2, rtol=1e-6)


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> None:
    expected = Rotation.from_euler("xyz", (roll, pitch, yaw))
    same_rotation(spatial.quaternion_from_rpy(roll, pitch, yaw), expected.as_quat())
    np.testing.assert_allclose(spatial.rpy_from_rotation(expected.as_matrix()), (roll, pitch, yaw), atol=1e-7)


@given(vector, vector)
def test_cross_and_skew(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    np.testing.assert_allclose(spatial.cross(a, b), np.cross(a, b), **TIGHT)
    np.testing.assert_allclose(spatial.skew(a) @ np.array(b), np.cross(a, b), **TIGHT)


@given(vector, vector, vector, vector)
def test_a_wrench_does_the_same_work_about_any_point(
    force: tuple[float, ...], torque: tuple[float, ...], offset: tuple[float, ...], omega: tuple[float, ...]
) -> None:
    """Power of a rotation about the new origin; the old origin then moves with omega x offset."""
    wrench = np.array((*force, *torque))
    moved = spatial.wrench_about(wrench, offset)
    power = np.dot(wrench[:3], np.cross(omega, offset)) + np.dot(wrench[3:], omega)
    assert np.dot(moved[3:], omega) == pytest.approx(power, abs=1e-8)
    np.testing.assert_array_equal(moved[:3], force)
    np.testing.assert_allclose(spatial.wrench_about(moved, -np.array(offset)), wrench, atol=1e-9)
    np.testing.assert_array_equal(wrench, (*force, *torque))


@given(vector, unit_quaternion, vector, unit_quaternion)
def test_pose_error(p: tuple[float, ...], q: np.ndarray, p_hat: tuple[float, ...], q_hat: np.ndarray) -> None:
    rotation, wanted = Rotation.from_quat(q), Rotation.from_quat(q_hat)
    expected = (rotation * wanted.inv()).as_rotvec()
    error = spatial.pose_error(p, rotation.as_matrix(), p_hat, wanted.as_matrix())
    np.testing.assert_allclose(error[:3], np.subtract(p, p_hat), **TIGHT)
    if np.linalg.norm(expected) < math.pi - 1e-4:
        np.testing.assert_allclose(error[3:], expected, atol=1e-7)


@pytest.mark.parametrize("q", [(0, 0, 0, 0), (math.nan, 0, 0, 1), (math.inf, 0, 0, 1), (1e300, 1e300, 0, 0)])
def test_what_is_no_rotation_is_refused(q: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="no rotation"):
        spatial.rotation_matrix(q)
