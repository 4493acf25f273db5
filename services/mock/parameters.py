"""The mock robot's parameters."""

from __future__ import annotations

import math
from typing import Literal

from shared.parameters import Parameters, Vector3, Vector6, option, parameter


class MockParameters(Parameters):
    """Rates, limits of the gate, and what acts on the tool."""

    rate: float = parameter(100.0, "Hz", 30.0, 1000.0, "of sensor/ft")
    pose_rate: float = parameter(1000.0, "Hz", 20.0, 1000.0, "of state/ee, at most rate")
    steps: int = parameter(1, "", 1, 100, "steps of the gate per sample of sensor/ft")
    base_type: Literal["differential", "omni"] = option("differential", "kind of mobile base")
    require_enable: bool = option(False, "the gate moves nothing but while `operator/enable` is pressed")
    max_linear: float = parameter(0.5, "m/s", 0.01, 2.0, "largest speed of the tool's origin")
    max_angular: float = parameter(1.0, "rad/s", 0.01, 3.0, "largest turning rate of the tool")
    position: Vector3 = option((0.5, -0.3, 1.0), "of the tool at the start, in base", unit="m")
    still: bool = option(False, "the tool stays where it is, whatever the gate lets through: a first day with a robot")
    wrench: Vector6 = option((0.0,) * 6, "that acts on the tool's origin, base axes", unit="N, Nm")
    noise: Vector6 = parameter(
        (0.02,) * 3 + (0.002,) * 3, "N, Nm", 0.0, math.inf, "standard deviation of the sensor's, per axis"
    )
