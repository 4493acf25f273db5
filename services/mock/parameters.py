"""The mock robot's parameters."""

from __future__ import annotations

from typing import Literal

from shared.parameters import Parameters, Vector3, Vector6, parameter


class MockParameters(Parameters):
    """Rates, limits of the gate, and what acts on the tool."""

    rate: float = parameter(100.0, unit="Hz", minimum=30.0, maximum=1000.0, doc="of sensor/ft")
    pose_rate: float = parameter(
        1000.0, unit="Hz", minimum=20.0, maximum=1000.0, doc="of state/ee, at most rate"
    )
    steps: int = parameter(
        1, unit="", minimum=1, maximum=100, doc="steps of the gate per sample of sensor/ft"
    )
    base_type: Literal["differential", "omni"] = parameter("differential", unit="", doc="kind of mobile base")
    max_linear: float = parameter(
        0.5, unit="m/s", minimum=0.01, maximum=2.0, doc="largest speed of the tool's origin"
    )
    max_angular: float = parameter(
        1.0, unit="rad/s", minimum=0.01, maximum=3.0, doc="largest turning rate of the tool"
    )
    position: Vector3 = parameter((0.5, -0.3, 1.0), unit="m", doc="of the tool at the start, in base")
    still: bool = parameter(
        False,
        unit="",
        doc="the tool stays where it is, whatever the gate lets through: a first day with a robot",
    )
    wrench: Vector6 = parameter((0.0,) * 6, unit="N, Nm", doc="that acts on the tool's origin, base axes")
    noise: Vector6 = parameter(
        (0.02,) * 3 + (0.002,) * 3,
        unit="N, Nm",
        minimum=0.0,
        doc="standard deviation of the sensor's, per axis",
    )
