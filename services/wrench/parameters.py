"""Parameters of the wrench service."""

from __future__ import annotations

from shared.parameters import Parameters, Vector6, parameter


class WrenchParameters(Parameters):
    """Names, units and ranges; vectors of six are along x, y, z and about x, y, z of the sensor."""

    lowpass_hz: float = parameter(
        0.0,
        unit="Hz",
        minimum=0.0,
        maximum=1000.0,
        doc="corner of the low pass, 0 = off; its lag 1/(2 pi f) counts in the controller's delay",
    )
    noise_bound: Vector6 = parameter(
        (0.5, 0.5, 0.5, 0.025, 0.025, 0.025),
        unit="N, Nm",
        minimum=1e-6,
        maximum=100.0,
        doc="bound on the noise of a raw reading: five standard deviations of the sensor",
    )
    bias_bound: Vector6 = parameter(
        (3.0, 3.0, 3.0, 0.3, 0.3, 0.3),
        unit="N, Nm",
        minimum=0.0,
        maximum=1000.0,
        doc="bound on the bias of the sensor as long as nothing was tared",
    )
    tool_mass: float = parameter(
        0.83,
        unit="kg",
        minimum=0.0,
        maximum=50.0,
        doc="largest mass beyond the sensor while it is not identified (TIAGo's gripper: 0.8226)",
    )
    tool_reach: float = parameter(
        0.1,
        unit="m",
        minimum=0.0,
        maximum=2.0,
        doc="largest distance of that mass' centre from the tool's origin",
    )
    stuck_after: float = parameter(
        0.1,
        unit="s",
        minimum=0.02,
        maximum=1.0,
        doc="time within which an axis that repeats one value is reported as stuck; raise it for a coarse sensor",
    )
    max_delay: float = parameter(
        0.02,
        unit="s",
        minimum=1e-3,
        maximum=0.2,
        doc="bound on how much later than the fastest one a sample may arrive",
    )
    payload: str = parameter("", unit="", doc="TOML file of an identified payload, empty = none")
