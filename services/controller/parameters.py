"""The controller's parameters."""

from __future__ import annotations

from typing import Literal

from services.controller.bounds.contact_zone import ContactZone
from shared.messages import LONGEST_TTL
from shared.parameters import Parameters, Vector3, Vector6, check_range, option, parameter

LawName = Literal["certified", "paper", "stiffness"]
_OF_CERTIFIED = (
    "contact_stiffness", "contact_reach", "contact_friction", "zones", "reserve", "yield_start", "payload_mass",
    "max_retreat_acceleration",
)  # fmt: skip
_IGNORED: dict[str, tuple[str, ...]] = {
    "certified": ("barrier_rate", "spring_stiffness"),
    "paper": (*_OF_CERTIFIED, "spring_stiffness"),
    "stiffness": (*_OF_CERTIFIED, "barrier_rate"),
}
"""Parameters that each law does not read."""


class ControllerParameters(Parameters):
    """Law, what the environment may be like, how the robot is connected, and how fast it may move."""

    law: LawName = option("certified", "certified: force limits proven; paper: Dawson et al.; stiffness: a spring")
    lyapunov_rate: float = parameter(10.0, "1/s", 0.01, 100.0, "lambda, wanted rate of the Lyapunov function")
    relaxation_weight: float = parameter(
        1.0,
        "1",
        0.01,
        100.0,
        "k; caps the pull to the target: the free tool converges with min(k, lambda)/2 per second",
    )
    barrier_rate: Vector6 = parameter((1.0,) * 6, "1/s per N/m, Nm/rad", 1e-4, 1e3, "alpha of the law paper, per axis")
    contact_stiffness: float = parameter(500.0, "N/m", 1.0, 1e7, "kappa, largest stiffness, sum over all contacts")
    contact_reach: Vector3 = parameter(
        (1.2, 0.3, 0.05), "m", 1e-3, 5.0, "farthest contact from the tool origin, tool axes"
    )
    contact_friction: float = parameter(0.0, "1", 0.0, 2.0, "mu of contacts that slip")
    zones: tuple[ContactZone, ...] = option(
        (),
        "further contact zones {stiffness [N/m], reach [m], friction}, each within the ranges of contact_*; "
        "their stiffnesses add up",
    )
    reserve: float = parameter(0.1, "1", 0.0, 0.5, "share of the limit that pressing leaves for sliding and retreat")
    yield_start: float = parameter(1.0, "1", 0.5, 1.0, "share of the limit where yielding begins; 1 = only beyond it")
    period: float = parameter(0.02, "s", 1e-3, LONGEST_TTL, "T, longest time one command acts; sent as its ttl")
    delay: float = parameter(0.02, "s", 0.0, 0.1, "d, from contact to sample plus from command to motion, at most")
    lag: float = parameter(0.02, "s", 0.0, 0.5, "tau, lag of the robot's motion")
    payload_mass: float = parameter(
        0.0,
        "kg",
        0.0,
        20.0,
        "mass beyond the sensor; times max_acceleration it counts as force that no contact exerts. Not counted is "
        "its torque, mass x acceleration x distance of the centre of mass from the tool origin: keep that below the "
        "torque's error_bound, by a centre of mass close to the tool or a lower max_acceleration",
    )
    spring_stiffness: Vector6 = parameter(
        (40.0, 40.0, 40.0, 10.0, 10.0, 10.0), "N/m, Nm/rad", 1e-2, 1e5, "of the law stiffness"
    )
    max_linear: float = parameter(0.25, "m/s", 1e-3, 1.0, "largest speed of the tool origin")
    max_angular: float = parameter(0.5, "rad/s", 1e-3, 3.0, "largest turning rate of the tool")
    max_acceleration: Vector6 = parameter(
        (2.0, 2.0, 2.0, 2.5, 2.5, 2.5),
        "m/s2, rad/s2",
        0.01,
        1e4,
        "of speeding up, tool axes; slowing down is never limited",
    )
    max_retreat_acceleration: Vector6 = parameter(
        (10.0, 10.0, 10.0, 20.0, 20.0, 20.0),
        "m/s2, rad/s2",
        0.01,
        1e4,
        "of giving way, where that is more than max_acceleration; without effect if there is a payload_mass, whose "
        "inertia would look like a force",
    )

    def check(self) -> None:
        """Refuse zones beyond the ranges of the first one, which is given by ``contact_*``."""
        for index, zone in enumerate(self.zones):
            for name in ("stiffness", "reach", "friction"):
                declared = type(self).model_fields[f"contact_{name}"]
                check_range(f"zones[{index}].{name}", getattr(zone, name), declared)

    @property
    def ignored(self) -> str:
        """What was set and has no effect under the law, in words; empty if all has."""
        names = [name for name in _IGNORED[self.law] if name in self.model_fields_set]
        return f"without effect under law {self.law}: {', '.join(names)}" if names else ""

    @property
    def retreat_acceleration(self) -> Vector6:
        """(6,) [m/s2, rad/s2], tool axes, of giving way."""
        if self.payload_mass > 0.0:
            return self.max_acceleration
        x, y, z, a, b, c = map(max, self.max_acceleration, self.max_retreat_acceleration)
        return x, y, z, a, b, c

    @property
    def premises(self) -> tuple[object, ...]:
        """What the travel in flight was bounded with."""
        return self.law, self.period, self.delay, self.lag, self.contact_zones

    @property
    def contact_zones(self) -> tuple[ContactZone, ...]:
        """All zones: the one of the ``contact_*`` parameters first."""
        first = ContactZone(self.contact_stiffness, self.contact_reach, self.contact_friction)
        return (first, *self.zones)

    @property
    def horizon(self) -> float:
        """T + d + tau [s], from a sample until the command that it leads to has acted."""
        return self.period + self.delay + self.lag
