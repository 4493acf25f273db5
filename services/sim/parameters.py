"""The simulated robot's parameters."""

from __future__ import annotations

from typing import Literal

from shared.parameters import Parameters, Vector6, parameter

BaseType = Literal["differential", "omni"]


class SimParameters(Parameters):
    """Rates, sensor errors and speed limits of the simulated TIAGo."""

    ft_rate: float = parameter(
        100.0, unit="Hz", minimum=30.0, maximum=1000.0, doc="of the wrist's force-torque sensor"
    )
    ft_noise: Vector6 = parameter(
        (0.1, 0.1, 0.1, 0.005, 0.005, 0.005),
        unit="N, Nm",
        minimum=0.0,
        maximum=50.0,
        doc="standard deviation of its noise, per axis",
    )
    ft_bias: Vector6 = parameter(
        (0.0,) * 6, unit="N, Nm", minimum=-100.0, maximum=100.0, doc="its constant error, per axis"
    )
    joint_rate: float = parameter(
        100.0, unit="Hz", minimum=50.0, maximum=1000.0, doc="of joint states and of the tool's pose"
    )
    camera_rate: float = parameter(10.0, unit="Hz", minimum=1.0, maximum=30.0, doc="of the head camera")
    base_type: BaseType = parameter("differential", unit="", doc="kind of mobile base")
    physics_rate: float = parameter(
        500.0, unit="Hz", minimum=500.0, maximum=4000.0, doc="of physics steps, at least"
    )
    real_time_factor: float = parameter(
        1.0,
        unit="1",
        minimum=0.01,
        maximum=10.0,
        doc="simulated seconds per second; commands' ttl stays in real time",
    )
    max_linear: float = parameter(
        0.3, unit="m/s", minimum=0.01, maximum=1.0, doc="largest speed of the tool's origin"
    )
    max_angular: float = parameter(
        1.0, unit="rad/s", minimum=0.01, maximum=3.0, doc="largest turning rate of the tool"
    )
    max_linear_acceleration: float = parameter(
        5.0, unit="m/s2", minimum=0.1, maximum=100.0, doc="of speeding up; slowing down is not limited"
    )
    max_angular_acceleration: float = parameter(
        10.0, unit="rad/s2", minimum=0.1, maximum=100.0, doc="of speeding up; slowing down is not limited"
    )
    seed: int = parameter(0, unit="", minimum=0, maximum=2**63 - 1, doc="of the sensor noise")
