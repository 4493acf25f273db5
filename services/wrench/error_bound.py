"""Bound on the error of the published wrench: |published - true| <= bound, axis by axis, in base axes at the tool.

The error has two parts.

In sensor axes: noise of a reading and error of the bias, each a box of half-widths s. Transport to the tool and
rotation to base are linear, so the largest error of axis i over the box is sum_j |T_ij| s_j, where
T = diag(R, R) [I 0; -[o]x I] and o is the tool's offset. This is exact for a box and needs no distribution. The error
of the bias grows with its age (`bias_error`): a sensor's zero drifts.

In base axes: weight that the compensation does not know. With mass m and d the uncompensated part of gravity, the error
of the force is m d and that of the torque about the tool r x m d, where r is the centre of mass from the tool's origin,
|r| <= rho: axis i of it is at most m rho sqrt(|d|^2 - d_i^2). With u the unit vector of gravity as the robot tells it
    none     d = g u: the whole weight
    tare     d = g (u - Q u_0), Q the rotation since the tare: zero in the tare's orientation and under any turn about
             the vertical, g times the tilt otherwise
    payload  the error of the identified mass and moment, along u alone: d = g u with the error of the mass
Gravity itself may be off from what the robot tells, by an angle t at most: by |d| <= 2 g sin(t/2) in any direction,
now, and by as much again when the zero was measured, since the robot may have stood elsewhere or turned on its ramp.
Forces that accelerate the mass beyond the sensor are not in this bound: the controller accounts for them by its
`payload_mass` and `max_acceleration`. The lag of the low pass is no error of this kind either: it counts as delay.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from services.wrench.compensation import Compensation, weight_of_up
from shared.spatial import GRAVITY, Array

NO_ZERO = -1.0
"""Age of a bias that was not measured in this run of the robot process."""
_MINUTE = 60.0  # [s]
_HALVES = np.kron(np.eye(2), np.ones((3, 1)))  # sums the first and the last three elements


def bias_error(compensation: Compensation, age: float, drift: Array, bias_bound: Array) -> Array:
    """Bound (6,) [N, Nm] on the error of the bias at an age, sensor axes.

    Args:
        compensation: that the bias belongs to.
        age: of the bias [s], or `NO_ZERO`.
        drift: declared bound (6,) [N, Nm per minute] on how fast the sensor's zero drifts.
        bias_bound: declared bound (6,) on the error of a bias that no zero of this run tells: however old a zero is, it
            is no worse than that.
    """
    most = np.maximum(compensation.bias_error, bias_bound)
    return most if age < 0.0 else np.minimum(compensation.bias_error + drift * (age / _MINUTE), most)


def unknown_weight(mass: float, reach: float, field: tuple[float, float, float]) -> Array:
    """Largest wrench (6,) [N, Nm] about the tool of a mass in a field, base axes.

    Args:
        mass: [kg].
        reach: largest distance [m] of the mass' centre from the tool's origin.
        field: d (3,) [m/s^2], base axes.
    """
    x, y, z = field
    lever = mass * reach
    return np.array(
        (
            mass * abs(x),
            mass * abs(y),
            mass * abs(z),
            lever * math.hypot(y, z),
            lever * math.hypot(x, z),
            lever * math.hypot(x, y),
        )
    )


def error_bound(
    compensation: Compensation,
    rotation: Array,
    to_tool: Array,
    box: Array,
    tool: tuple[float, float],
    gravity: Array,
    tilt: float,
) -> Array:
    """Bound (6,) [N, Nm] on the error of the external wrench, base axes, about the tool.

    Args:
        compensation: what was subtracted.
        rotation: sensor in base (3, 3).
        to_tool: `transport` (6, 6) of the sample.
        box: bound (6,) on the noise of a reading and the error of the bias together, sensor axes.
        tool: largest mass [kg] beyond the sensor, and largest distance [m] of its centre from the tool's origin.
        gravity: unit vector (3,) of gravity in base axes, as the robot tells it.
        tilt: largest angle [rad] between that and gravity.
    """
    slope = 2.0 * GRAVITY * math.sin(0.5 * tilt)
    x, y, z = gravity.tolist()
    if compensation.kind == "payload":
        # The wrong weight acts at the sensor's origin, straight down; what its moment is wrong by turns about the rest.
        weights = to_tool.dot(_weights(compensation))
        lengths = np.sqrt((weights * weights).dot(_HALVES))
        weight = np.abs(weights[:, 3:].dot(gravity.dot(rotation))) + lengths.dot((2.0 * slope, slope)) / GRAVITY
        across = (math.hypot(y, z), math.hypot(x, z), math.hypot(x, y))
        weight[3:] += [compensation.moment_error * (GRAVITY * part + slope) for part in across]
    else:
        mass, reach = tool
        if compensation.kind == "tare":
            a, b, c = rotation.dot(compensation.up).tolist()
            x, y, z, slope = x + a, y + b, z + c, 2.0 * slope
        weight = unknown_weight(mass, reach, (GRAVITY * x, GRAVITY * y, GRAVITY * z))
        weight[:3] += mass * slope
        weight[3:] += mass * reach * slope
    return np.abs(to_tool).dot(box) + weight


@lru_cache(maxsize=4)
def _weights(compensation: Compensation) -> Array:
    """Matrix (6, 6) that acts on two directions in sensor axes: one's known weight, the other's mass error."""
    wrong = np.vstack((compensation.mass_error * GRAVITY * np.eye(3), np.zeros((3, 3))))
    return np.hstack((weight_of_up(compensation), wrong))
