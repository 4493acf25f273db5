"""Bound on the error of the published wrench: |published - true| <= bound, axis by axis, in base axes at the tool.

The error has two parts.

In sensor axes: noise of a reading and error of the bias, each a box of half-widths s. Transport to the tool and
rotation to base are linear, so the largest error of axis i over the box is sum_j |T_ij| s_j, where
T = diag(R, R) [I 0; -[o]x I] and o is the tool's offset. This is exact for a box and needs no distribution.

In base axes: weight that the compensation does not know. With mass m and d the uncompensated part of gravity, the error
of the force is m d and that of the torque about the tool r x m d, where r is the centre of mass from the tool's origin,
|r| <= rho: axis i of it is at most m rho sqrt(|d|^2 - d_i^2). Here
    none     d = g z: the whole weight
    tare     d = g (z - Q z), Q the rotation since the tare: zero in the tare's orientation and under any turn about
             the vertical, g times the tilt otherwise
    payload  the error of the identified mass and moment, along z alone: d = g z with the error of the mass
Forces that accelerate the mass beyond the sensor are not in this bound: the controller accounts for them by its
`payload_mass` and `max_acceleration`. The lag of the low pass is no error of this kind either: it counts as delay.
"""

from __future__ import annotations

import math

import numpy as np

from services.wrench.compensation import Compensation
from shared.spatial import GRAVITY, Array


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
    noise_bound: Array,
    bias_bound: Array,
    tool_mass: float,
    tool_reach: float,
) -> Array:
    """Bound (6,) [N, Nm] on the error of the external wrench, base axes, about the tool.

    Args:
        compensation: what was subtracted.
        rotation: sensor in base (3, 3).
        to_tool: `transport` (6, 6) of the sample.
        noise_bound: declared bound (6,) on the noise of a reading, sensor axes; a larger measured one replaces it.
        bias_bound: declared bound (6,) on the bias of a sensor that was never tared, sensor axes.
        tool_mass: largest mass [kg] beyond the sensor.
        tool_reach: largest distance [m] of its centre from the tool's origin.
    """
    box = np.maximum(noise_bound, compensation.noise)
    if compensation.kind == "none":
        box = box + bias_bound
        weight = unknown_weight(tool_mass, tool_reach, (0.0, 0.0, GRAVITY))
    elif compensation.kind == "tare":
        box = box + compensation.bias_error
        x, y, z = rotation.dot(compensation.up).tolist()
        weight = unknown_weight(tool_mass, tool_reach, (-GRAVITY * x, -GRAVITY * y, GRAVITY * (1.0 - z)))
    else:
        box = box + compensation.bias_error
        # The wrong weight acts at the sensor's origin, straight down; what its moment is wrong by turns about x and y.
        weight = GRAVITY * compensation.mass_error * np.abs(to_tool[:, :3].dot(rotation[2]))
        weight[3:5] += GRAVITY * compensation.moment_error
    return np.abs(to_tool).dot(box) + weight
