"""Parameters of the base's admittance. Speeds and accelerations: the controllers of PAL's PMB2 and omni base."""

from __future__ import annotations

from shared.messages import RobotStatus
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

    def ignored(self, robot: RobotStatus) -> str:
        """What was set and has no effect with this robot, in words; empty if all has."""
        allowed = {"max_linear": robot.max_base[:2].max(), "max_angular": robot.max_base[2]}
        found = [f"{name} is above what the robot allows, {most:g}" for name, most in allowed.items()
                 if name in self.model_fields_set and getattr(self, name) > most]  # fmt: skip
        if "max_reverse" in self.model_fields_set:
            if robot.base_type == "omni":
                found.append("max_reverse has no effect on an omni base")
            elif self.max_reverse > self.max_linear:
                found.append(f"max_reverse has no effect above max_linear, {self.max_linear:g}")
        return "; ".join(found)
