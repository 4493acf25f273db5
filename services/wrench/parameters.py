"""Parameters of the wrench service."""

from __future__ import annotations

from shared.parameters import Parameters, Vector6, option, parameter


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
        (3.0, 3.0, 3.0, 0.3, 0.3, 0.3),
        "N, Nm",
        0.0,
        1000.0,
        "bound on the bias of the sensor as long as nothing was tared",
    )
    tool_mass: float = parameter(
        0.83, "kg", 0.0, 50.0, "largest mass beyond the sensor while it is not identified (TIAGo's gripper: 0.8226)"
    )
    tool_reach: float = parameter(0.1, "m", 0.0, 2.0, "largest distance of that mass' centre from the tool's origin")
    stuck_after: float = parameter(
        0.1,
        "s",
        0.02,
        1.0,
        "time within which an axis that repeats one value is reported as stuck; raise it for a coarse sensor",
    )
    max_delay: float = parameter(
        0.02, "s", 1e-3, 0.2, "bound on how much later than the fastest one a sample may arrive"
    )
    payload: str = option("", "TOML file of an identified payload, empty = none")
