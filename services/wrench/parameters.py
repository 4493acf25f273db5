"""Parameters of the wrench service."""

from __future__ import annotations

import math

from services.wrench.averaging import AXES, UNITS
from services.wrench.axis_watch import FEWEST_REPEATS
from shared.parameters import Parameters, Refused, Vector6, option, parameter
from shared.robot.tiago import SENSOR_RANGE
from shared.spatial import GRAVITY

LONGEST_LAG = 0.1
"""Lag [s] of the low pass beyond which no `delay` of the controller can count it."""


class WrenchParameters(Parameters):
    """Names, units and ranges; vectors of six are along x, y, z and about x, y, z of the sensor."""

    lowpass_hz: float = parameter(
        0.0, "Hz", 0.0, 1000.0, "corner of the low pass, 0 = off; its lag 1/(2 pi f) counts in the controller's delay"
    )
    noise_bound: Vector6 = parameter(
        (0.5, 0.5, 0.5, 0.025, 0.025, 0.025),
        "N, Nm",
        1e-6,
        100.0,
        "bound on the noise of a raw reading: five standard deviations of the sensor",
    )
    bias_bound: Vector6 = parameter(
        (5.0, 5.0, 5.0, 0.5, 0.5, 0.5),
        "N, Nm",
        0.0,
        1000.0,
        "bound on the bias of the sensor, or on its difference from a payload file's, without a zero of this run of "
        "the robot process; and on how far a zero drifts in the end",
    )
    zero_drift: Vector6 = parameter(
        (0.02, 0.02, 0.02, 0.001, 0.001, 0.001),
        "N, Nm per minute",
        0.0,
        100.0,
        "bound on how fast the zero of the sensor drifts, once it is warm; docs/sensing.md has a table of real ones",
    )
    zero_survives_restart: bool = option(
        False, "the sensor keeps its zero while the robot process restarts, which nobody but its maker can promise"
    )
    floor_tilt: float = parameter(
        0.005,
        "rad",
        0.0,
        0.5,
        "bound on the angle between gravity and what the robot tells of it: of the floor, where it tells nothing",
    )
    tool_mass: float = parameter(
        0.83, "kg", 0.0, 50.0, "largest mass beyond the sensor while it is not identified (TIAGo's gripper: 0.8226)"
    )
    tool_reach: float = parameter(0.1, "m", 0.0, 2.0, "largest distance of that mass' centre from the tool's origin")
    resolution: Vector6 = parameter(
        (0.0,) * 6,
        "N, Nm",
        0.0,
        100.0,
        "step of the readings, or reading up to which it is zero; adds to the bound; 0 = unknown",
    )
    sensor_range: Vector6 = parameter(
        tuple(SENSOR_RANGE.tolist()),
        "N, Nm",
        0.01,
        1e6,
        "largest reading of each axis (TIAGo's: Schunk Mini45): saturated at it, invalid beyond it",
    )
    stuck_after: float = parameter(
        0.1,
        "s",
        0.02,
        1.0,
        "time within which an axis that has lost its noise is reported as stuck; coarse ones take longer by themselves",
    )
    max_delay: float = parameter(
        0.02, "s", 1e-3, 0.2, "bound on how much later than the fastest one a sample may arrive"
    )
    payload: str = option("", "TOML file of an identified payload, empty = none")

    def check(self) -> None:
        """Hold the parameters against each other.

        Raises:
            Refused: if they contradict.
        """
        lag = 1.0 / (2.0 * math.pi * self.lowpass_hz) if self.lowpass_hz > 0.0 else 0.0
        if lag > LONGEST_LAG:
            raise Refused(
                f"lowpass_hz is {self.lowpass_hz:g}, which is {lag:.2g} s late: the controller's delay can count "
                f"{LONGEST_LAG:g} s at most; allowed is 0, or {1.0 / (2.0 * math.pi * LONGEST_LAG):.1f} Hz or more"
            )
        for axis, unit, noise, bias, step, end in zip(
            AXES, UNITS, self.noise_bound, self.bias_bound, self.resolution, self.sensor_range, strict=True
        ):
            if noise + bias + step >= end:
                raise Refused(
                    f"noise_bound, bias_bound and resolution are {noise + bias + step:g} {unit} together in {axis}, "
                    f"sensor_range is {end:g}: nothing could be told from them"
                )
        if self.tool_mass * GRAVITY >= max(self.sensor_range[:3]):
            raise Refused(
                f"tool_mass is {self.tool_mass:g} kg, its weight of {self.tool_mass * GRAVITY:.0f} N is beyond "
                f"sensor_range ({max(self.sensor_range[:3]):g} N)"
            )

    def unfit(self, period: float) -> str:
        """What of the parameters does not fit the sensor's period [s], empty if all do."""
        soonest = FEWEST_REPEATS * period
        if self.stuck_after < soonest:
            return (
                f"stuck_after is {self.stuck_after:g} s, samples come every {period:.3f} s: a stuck axis shows after "
                f"{soonest:.2f} s at the soonest. Raise stuck_after, or the sensor's rate"
            )
        if self.lowpass_hz * period > 0.5:
            return (
                f"lowpass_hz is {self.lowpass_hz:g}, beyond half the sensor's rate of {1.0 / period:.0f} Hz: no effect"
            )
        return ""
