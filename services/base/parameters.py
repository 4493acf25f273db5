"""Parameters of the base's admittance. Speeds and accelerations: the controllers of PAL's PMB2 and omni base."""

from __future__ import annotations

from shared.parameters import Parameters, parameter


class BaseParameters(Parameters):
    """The body that the wrench moves, what it ignores, and how fast it may become.

    The default speeds are those that the omni base allows in all directions together (0.4), the default acceleration
    is the lowest of all variants (0.7 m/s2). A lower ``state/robot.max_base`` wins over them.
    """

    mass: float = parameter(10.0, "kg", 1.0, 200.0, "M of the free-floating body")
    inertia: float = parameter(2.0, "kg m2", 0.1, 100.0, "I about the vertical")
    damping_linear: float = parameter(20.0, "N s/m", 1.0, 1000.0, "D; force over speed in the long run")
    damping_angular: float = parameter(10.0, "Nm s/rad", 0.5, 500.0, "torque over turning rate in the long run")
    dead_band_force: float = parameter(1.0, "N", 0.0, 50.0, "ignored along x and y; never less than the error_bound")
    dead_band_torque: float = parameter(
        1.0, "Nm", 0.0, 50.0, "ignored about the base's origin; never less than the error_bound carried over to it"
    )
    max_linear: float = parameter(0.4, "m/s", 0.01, 1.0, "largest speed")
    max_angular: float = parameter(0.4, "rad/s", 0.01, 2.09, "largest turning rate")
    max_reverse: float = parameter(0.2, "m/s", 0.0, 1.0, "largest speed backwards of a differential base")
    max_linear_acceleration: float = parameter(0.7, "m/s2", 0.05, 1.0, "of speeding up and of braking")
    max_angular_acceleration: float = parameter(2.0, "rad/s2", 0.05, 2.09, "of speeding up and of braking")
    max_delay: float = parameter(
        0.05, "s", 1e-3, 0.2, "bound on how much later than the fastest one an input may arrive"
    )
