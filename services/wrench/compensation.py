"""What of a raw reading is not the environment: the sensor's bias and the weight beyond the sensor.

A reading in sensor axes, about the sensor's origin, with nothing touching the tool, is

    force  = m g_s + b_f            g_s = R^T (0, 0, -9.81), R = sensor in upright axes
    torque = h x g_s + b_tau        h = m c, c = centre of mass in sensor axes

A tare knows only the sum at one orientation; an identified payload knows m, h, b_f and b_tau, thus every orientation.

Upright axes are base axes, turned by the shortest way so that z points against gravity as the robot tells it: base axes
where it tells nothing. Of R only the third row counts, the direction of gravity in the sensor.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from shared.schema.fields import Number, Text, Vector
from shared.schema.records import Record, of
from shared.spatial import GRAVITY, Array, cross, rotation_from_vector, skew

_ZERO3, _ZERO6, _ZERO9 = (0.0,) * 3, (0.0,) * 6, (0.0,) * 9


def upright(rotation: Array, gravity: Array) -> Array:
    """The sensor in upright axes (3, 3).

    Args:
        rotation: sensor in base (3, 3).
        gravity: unit vector (3,) of gravity in base axes, as the robot tells it.
    """
    x, y, z = gravity.tolist()
    sine = math.hypot(x, y)
    if sine == 0.0 and z < 0.0:
        return rotation
    # About gravity cross -z, which takes gravity to -z.
    turn = math.atan2(sine, -z) / sine if sine > 0.0 else math.pi
    axis = (-y, x, 0.0) if sine > 0.0 else (1.0, 0.0, 0.0)
    return rotation_from_vector([turn * element for element in axis]).dot(rotation)


def gravity_in_sensor(rotation: Array) -> Array:
    """Gravity (3,) [m/s^2] in sensor axes; ``rotation`` (3, 3) is the sensor in upright axes."""
    return -GRAVITY * rotation[2]


def payload_wrench(mass: float, moment: Array, rotation: Array) -> Array:
    """Weight (6,) [N, Nm] of what is beyond the sensor, sensor axes, about the sensor's origin.

    Args:
        mass: [kg].
        moment: mass times centre of mass (3,) [kg m], sensor axes.
        rotation: sensor in upright axes (3, 3).
    """
    gravity = gravity_in_sensor(rotation)
    return np.concatenate((mass * gravity, cross(moment, gravity)))


class Compensation(Record):
    """What is subtracted from each reading, and how well it is known; a journal holds these fields."""

    kind: str = of(Text(choices=("none", "tare", "payload")), default="none")
    bias: Array = of(Vector("N, Nm", "sensor axes", size=6), default=_ZERO6)
    bias_error: Array = of(
        Vector("N, Nm", "bound on the error of bias at the orientations it was measured in", size=6), default=_ZERO6
    )
    mass: float = of(Number("kg", "of the identified payload, 0 for none and tare"), default=0.0)
    moment: Array = of(Vector("kg m", "mass times centre of mass of the payload, sensor axes"), default=_ZERO3)
    mass_error: float = of(Number("kg", "bound on the error of mass"), default=0.0)
    moment_error: float = of(Number("kg m", "bound on the length of the error of moment"), default=0.0)
    noise: Array = of(
        Vector("N, Nm", "bound on the sensor's noise as measured while it stood still, 0 if never", size=6),
        default=_ZERO6,
    )
    up: Array = of(Vector("", "against gravity in sensor axes at the tare"), default=_ZERO3)
    misfit_rms: Array = of(Vector("N, Nm", "that an identification left, over its poses", size=6), default=_ZERO6)
    misfit_peak: Array = of(Vector("N, Nm", "as misfit_rms, the largest", size=6), default=_ZERO6)
    down: Array = of(Vector("", "gravity's direction in sensor axes that the misfit counts from"), default=_ZERO3)
    spread: Array = of(Vector("", "inverse covariance of gravity's direction over the poses", size=9), default=_ZERO9)
    warning: str = of(Text(doc="why it is implausible, where it was adopted by force"), default="")
    bias_bound: Array = of(Vector("N, Nm", "counts where larger: the declared is refuted", size=6), default=_ZERO6)
    tool_mass: float = of(Number("kg", "counts where larger: the declared is refuted"), default=0.0)
    drift: Array = of(Vector("N, Nm per min", "counts where larger: zero_drift is refuted", size=6), default=_ZERO6)

    def offset(self, rotation: Array) -> Array:
        """What to subtract (6,) [N, Nm] from a reading taken with the sensor at ``rotation`` in upright axes."""
        weight = self.weight(rotation)
        return self.bias if weight is None else self.bias + weight

    def weight(self, rotation: Array) -> Array | None:
        """Weight (6,) [N, Nm] of the identified payload, sensor axes; None without one."""
        return weight_of_up(self).dot(rotation[2]) if self.kind == "payload" else None

    def misfit(self, up: Array) -> Array:
        """Bound (6,) [N, Nm] on what an identified payload leaves unexplained, sensor axes.

        Args:
            up: against gravity (3,), sensor axes. Far from the attitudes of the poses the bound grows.
        """
        away = up + self.down
        return np.maximum(self.misfit_peak, math.sqrt(away.dot(self.spread.reshape(3, 3)).dot(away)) * self.misfit_rms)

    def tared(self, reading: Array, error: Array, noise: Array, rotation: Array) -> Compensation:
        """This compensation after a tare: the average ``reading`` (6,) is what nothing touching looks like.

        An identified payload stays known; only the bias is measured anew. Without one the bias takes in the weight.

        Args:
            reading: average of the raw readings (6,) [N, Nm], sensor axes.
            error: bound on the error of that average (6,).
            noise: bound on the noise of one reading (6,), measured.
            rotation: sensor in upright axes (3, 3) during the tare.
        """
        if self.kind == "payload":
            weight = payload_wrench(self.mass, self.moment, rotation)
            # The bias holds what the payload leaves unexplained here: from here on that counts anew.
            error, down = error + self.misfit_peak, -rotation[2]
            return self.replaced(
                bias=reading - weight, bias_error=error, noise=noise, down=down, warning="", bias_bound=_ZERO6
            )
        return Compensation(
            "tare",
            bias=reading,
            bias_error=error,
            noise=noise,
            up=rotation[2],
            drift=self.drift,
        )


@lru_cache(maxsize=4)
def weight_of_up(compensation: Compensation) -> Array:
    """`payload_wrench` as a matrix (6, 3) that acts on the upright z axis in sensor axes: alike for every reading."""
    return -GRAVITY * np.vstack((compensation.mass * np.eye(3), skew(compensation.moment)))


def transport(rotation: Array, tool_offset: Array) -> Array:
    """Matrix (6, 6) that takes a wrench about the sensor in sensor axes to one about the tool in base axes.

    With o the tool's offset: force_base = R f, torque_base = R (tau - o x f).

    Args:
        rotation: sensor in base (3, 3).
        tool_offset: tool's origin from the sensor's origin (3,) [m], sensor axes.
    """
    x, y, z = tool_offset.tolist()
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    return np.array(
        (
            (a, b, c, 0.0, 0.0, 0.0),
            (d, e, f, 0.0, 0.0, 0.0),
            (g, h, i, 0.0, 0.0, 0.0),
            (c * y - b * z, a * z - c * x, b * x - a * y, a, b, c),
            (f * y - e * z, d * z - f * x, e * x - d * y, d, e, f),
            (i * y - h * z, g * z - i * x, h * x - g * y, g, h, i),
        )
    )
