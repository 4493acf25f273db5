"""Parameters of the base's admittance. Speeds and accelerations: the controllers of PAL's PMB2 and omni base."""

from __future__ import annotations

from shared.parameters import Parameters, parameter


class BaseParameters(Parameters):
    """The body that the wrench moves, what it ignores, and how fast it may become.

    The default speeds are those that the omni base allows in all directions together (0.4), the default acceleration
    is the lowest of all variants (0.7 m/s2). A lower ``state/robot.max_base`` wins over them.
    """

    mass: float = parameter(10.0, unit="kg", minimum=1.0, maximum=200.0, doc="M of the free-floating body")
    inertia: float = parameter(2.0, unit="kg m2", minimum=0.1, maximum=100.0, doc="I about the vertical")
    damping_linear: float = parameter(
        20.0, unit="N s/m", minimum=1.0, maximum=1000.0, doc="D; force over speed in the long run"
    )
    damping_angular: float = parameter(
        10.0, unit="Nm s/rad", minimum=0.5, maximum=500.0, doc="torque over turning rate in the long run"
    )
    dead_band_force: float = parameter(
        1.0, unit="N", minimum=0.0, maximum=50.0, doc="ignored along x and y; never less than the error_bound"
    )
    dead_band_torque: float = parameter(
        1.0,
        unit="Nm",
        minimum=0.0,
        maximum=50.0,
        doc="ignored about the base's origin; never less than the error_bound carried over to it",
    )
    max_linear: float = parameter(0.4, unit="m/s", minimum=0.01, maximum=1.0, doc="largest speed")
    max_angular: float = parameter(0.4, unit="rad/s", minimum=0.01, maximum=2.09, doc="largest turning rate")
    max_reverse: float = parameter(
        0.2, unit="m/s", minimum=0.0, maximum=1.0, doc="largest speed backwards of a differential base"
    )
    max_linear_acceleration: float = parameter(
        0.7, unit="m/s2", minimum=0.05, maximum=1.0, doc="of speeding up and of braking"
    )
    max_angular_acceleration: float = parameter(
        2.0, unit="rad/s2", minimum=0.05, maximum=2.09, doc="of speeding up and of braking"
    )
    max_delay: float = parameter(
        0.05,
        unit="s",
        minimum=1e-3,
        maximum=0.2,
        doc="bound on how much later than the fastest one an input may arrive",
    )
