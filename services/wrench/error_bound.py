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

from services.wrench.compensation import GRAVITY, Compensation
from shared.spatial import Array

_UP = np.array((0.0, 0.0, 1.0))


def transported(box: Array, rotation: Array, tool_offset: Array) -> Array:
    """Largest error (6,) in base axes at the tool of an error within a box in sensor axes about the sensor.

    Args:
        box: half-widths (6,) [N, Nm].
        rotation: sensor in base (3, 3).
        tool_offset: tool's origin from the sensor's origin (3,) [m], sensor axes.
    """
    x, y, z = tool_offset.tolist()
    offset_cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    size = np.abs(rotation)
    return np.concatenate((size @ box[:3], size @ box[3:] + np.abs(rotation @ offset_cross) @ box[:3]))


def unknown_weight(mass: float, reach: float, direction: Array) -> Array:
    """Largest wrench (6,) [N, Nm] about the tool of a mass in a field, base axes.

    Args:
        mass: [kg].
        reach: largest distance [m] of the mass' centre from the tool's origin.
        direction: the field d (3,) [m/s^2], base axes.
    """
    squares = direction * direction
    levers = np.sqrt(np.maximum(squares.sum() - squares, 0.0))
    return mass * np.concatenate((np.abs(direction), reach * levers))


def error_bound(
    compensation: Compensation,
    rotation: Array,
    tool_offset: Array,
    noise_bound: Array,
    bias_bound: Array,
    tool_mass: float,
    tool_reach: float,
) -> Array:
    """Bound (6,) [N, Nm] on the error of the external wrench, base axes, about the tool.

    Args:
        compensation: what was subtracted.
        rotation: sensor in base (3, 3).
        tool_offset: tool's origin from the sensor's origin (3,) [m], sensor axes.
        noise_bound: declared bound (6,) on the noise of a reading, sensor axes; a larger measured one replaces it.
        bias_bound: declared bound (6,) on the bias of a sensor that was never tared, sensor axes.
        tool_mass: largest mass [kg] beyond the sensor.
        tool_reach: largest distance [m] of its centre from the tool's origin.
    """
    noise = np.maximum(noise_bound, compensation.noise)
    if compensation.kind == "none":
        box = noise + bias_bound
        weight = unknown_weight(tool_mass, tool_reach, GRAVITY * _UP)
    elif compensation.kind == "tare":
        box = noise + compensation.bias_error
        weight = unknown_weight(tool_mass, tool_reach, GRAVITY * (_UP - rotation @ compensation.up))
    else:
        box = noise + compensation.bias_error
        lever = math.sqrt(float(tool_offset @ tool_offset))
        weight = unknown_weight(compensation.mass_error, lever, GRAVITY * _UP)
        weight[3:5] += GRAVITY * compensation.moment_error
    return transported(box, rotation, tool_offset) + weight
