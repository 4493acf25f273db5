"""Parameters that every bridge has."""

from __future__ import annotations

from shared.parameters import Parameters, option, parameter


class BridgeParameters(Parameters):
    """The robot, how much of it may be used, and the limits of the gate.

    A bridge whose middleware needs more to be told derives from this.
    """

    profile: str = option("tiago-ros1", "of the robot: the name of one that is shipped, or the path of a .toml file")
    read_only: bool = option(False, "watch, and publish what the robot says; never command anything")
    scale: float = parameter(1.0, "1", 0.01, 1.0, "share of all limits of speed and acceleration: 0.1 on a first day")
    require_enable: bool = option(True, "the gate moves nothing but while `operator/enable` is pressed")
    rate: float = parameter(200.0, "Hz", 50.0, 1000.0, "of the loop; a sensor that is faster is sampled")
    command_rate: float = parameter(50.0, "Hz", 20.0, 200.0, "of the trajectories that a moving arm is sent")
    max_linear: float = parameter(0.3, "m/s", 0.01, 1.0, "largest speed of the tool's origin")
    max_angular: float = parameter(1.0, "rad/s", 0.01, 3.0, "largest turning rate of the tool")
    max_linear_acceleration: float = parameter(5.0, "m/s2", 0.1, 100.0, "of speeding up")
    max_angular_acceleration: float = parameter(10.0, "rad/s2", 0.1, 100.0, "of speeding up")
