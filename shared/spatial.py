"""Rotations, twists and wrenches in the conventions of the Zenoh contract.

Quaternions are ``[x, y, z, w]``, scalar last and of unit norm. A rotation matrix ``R`` of frame *b* in frame *a*
takes coordinates in *b* to coordinates in *a*. Six-vectors put the translational part first: twist ``[v; omega]``,
wrench ``[f; tau]``.

These few formulas are written out because one call of a general rotation class costs 15 to 70 microseconds, more than
the rest of a control tick; the tests hold them against scipy's implementation.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
"""Standard gravity [m/s2], as the contract rounds it: a mass of 1 kg that hangs from the tool gives -9.81 N."""
_SMALL_ANGLE = 1e-7


def rotation_matrix(quaternion_xyzw: ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a quaternion (4,), which is normalised first.

    Raises:
        ValueError: if the quaternion has zero or non-finite norm.
    """
    x, y, z, w = np.asarray(quaternion_xyzw, dtype=float).tolist()
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not 0.0 < norm < math.inf:
        raise ValueError(f"a quaternion of norm {norm} is no rotation")
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
    )


def quaternion(rotation: Array) -> Array:
    """Unit quaternion (4,) ``[x, y, z, w]`` with w >= 0 of a rotation matrix (3, 3)."""
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation.tolist()
    # Of the four squares 4x^2 .. 4w^2 the largest is at least 1, which keeps the division well conditioned.
    squares = (1 + r00 - r11 - r22, 1 - r00 + r11 - r22, 1 - r00 - r11 + r22, 1 + r00 + r11 + r22)
    largest = max(range(4), key=squares.__getitem__)
    if largest == 0:
        parts = (squares[0], r01 + r10, r02 + r20, r21 - r12)
    elif largest == 1:
        parts = (r01 + r10, squares[1], r12 + r21, r02 - r20)
    elif largest == 2:
        parts = (r02 + r20, r12 + r21, squares[2], r10 - r01)
    else:
        parts = (r21 - r12, r02 - r20, r10 - r01, squares[3])
    result = np.array(parts)
    result /= math.copysign(math.sqrt(float(result @ result)), parts[3])
    return result


def rotation_vector(rotation: Array) -> Array:
    """Rotation vector (3,) [rad] of a rotation matrix (3, 3): axis times angle, angle in [0, pi]."""
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation.tolist()
    trace = r00 + r11 + r22
    if trace > 1.0:  # below 90 degrees the skew part alone is well conditioned, and three times as fast
        x, y, z = r21 - r12, r02 - r20, r10 - r01
        twice_sine = math.sqrt(x * x + y * y + z * z)
        scale = 0.5 if twice_sine < _SMALL_ANGLE else math.atan2(twice_sine, trace - 1.0) / twice_sine
        return np.array((scale * x, scale * y, scale * z))
    x, y, z, w = quaternion(rotation).tolist()
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 if sine < _SMALL_ANGLE else 2.0 * math.atan2(sine, w) / sine
    return np.array((scale * x, scale * y, scale * z))


def rotation_from_vector(vector: ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad] (Rodrigues' formula)."""
    return rotation_matrix(quaternion_from_vector(vector))


def quaternion_from_vector(vector: ArrayLike) -> Array:
    """Unit quaternion (4,) ``[x, y, z, w]`` of a rotation vector (3,) [rad]."""
    x, y, z = (float(value) for value in vector)  # type: ignore[arg-type, union-attr]
    angle = math.sqrt(x * x + y * y + z * z)
    scale = 0.5 if angle < _SMALL_ANGLE else math.sin(angle / 2) / angle
    return np.array((scale * x, scale * y, scale * z, math.cos(angle / 2)))


def quaternion_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Unit quaternion (4,) of roll, pitch, yaw [rad]: rotations about the fixed x, then y, then z axis."""
    rotation = (
        rotation_from_vector((0.0, 0.0, yaw))
        @ rotation_from_vector((0.0, pitch, 0.0))
        @ rotation_from_vector((roll, 0.0, 0.0))
    )
    return quaternion(rotation)


def rpy_from_rotation(rotation: Array) -> Array:
    """Roll, pitch, yaw (3,) [rad] of a rotation matrix (3, 3), the inverse of ``quaternion_from_rpy``."""
    pitch = math.asin(min(1.0, max(-1.0, -float(rotation[2, 0]))))
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    return np.array((roll, pitch, yaw))


def skew(vector: ArrayLike) -> Array:
    """Cross-product matrix (3, 3): ``skew(a) @ b`` equals ``a x b``."""
    x, y, z = (float(value) for value in vector)  # type: ignore[arg-type, union-attr]
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def cross(a: ArrayLike, b: ArrayLike) -> Array:
    """Cross product (3,) of two vectors (3,); a tenth of the time of numpy's general one."""
    ax, ay, az = (float(value) for value in a)  # type: ignore[arg-type, union-attr]
    bx, by, bz = (float(value) for value in b)  # type: ignore[arg-type, union-attr]
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def wrench_about(wrench: Array, offset: ArrayLike) -> Array:
    """Wrench (6,) taken about another point.

    Args:
        wrench: force [N] and torque [Nm] about the old origin.
        offset: vector (3,) [m] from the new origin to the old origin, in the wrench's axes.
    """
    moved = wrench.copy()
    moved[3:] += cross(offset, wrench[:3])
    return moved


def pose_error(position: ArrayLike, rotation: Array, target_position: ArrayLike, target_rotation: Array) -> Array:
    """Pose error (6,) ``[p - p_hat; theta]`` [m, rad], theta the rotation vector of ``R R_hat^T`` in base axes."""
    error = np.empty(6)
    np.subtract(position, target_position, out=error[:3])
    error[3:] = rotation_vector(rotation.dot(target_rotation.T))  # half the time of @ for so small a product
    return error
