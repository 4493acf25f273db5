"""The controller's parameters."""

from __future__ import annotations

from typing import Literal

from services.controller.bounds.contact_zone import ContactZone
from shared.messages import LONGEST_TTL
from shared.parameters import Parameters, Vector3, Vector6, check_range, parameter

LawName = Literal["certified", "paper", "stiffness"]


class ControllerParameters(Parameters):
    """Law, what the environment may be like, how the robot is connected, and how fast it may move."""

    law: LawName = parameter(
        "certified", unit="", doc="certified: force limits proven; paper: Dawson et al.; stiffness: a spring"
    )
    lyapunov_rate: float = parameter(
        10.0, unit="1/s", minimum=0.01, maximum=100.0, doc="lambda, wanted rate of the Lyapunov function"
    )
    relaxation_weight: float = parameter(
        1.0,
        unit="1",
        minimum=0.01,
        maximum=100.0,
        doc="k; caps the pull to the target: the free tool converges with min(k, lambda)/2 per second",
    )
    barrier_rate: Vector6 = parameter(
        (1.0,) * 6,
        unit="1/s per N/m, Nm/rad",
        minimum=1e-4,
        maximum=1e3,
        doc="alpha of the law paper, per axis",
    )
    contact_stiffness: float = parameter(
        500.0, unit="N/m", minimum=1.0, maximum=1e7, doc="kappa, largest stiffness, sum over all contacts"
    )
    contact_reach: Vector3 = parameter(
        (1.2, 0.3, 0.05),
        unit="m",
        minimum=1e-3,
        maximum=5.0,
        doc="farthest contact from the tool origin, tool axes",
    )
    contact_friction: float = parameter(
        0.0, unit="1", minimum=0.0, maximum=2.0, doc="mu of contacts that slip"
    )
    zones: tuple[ContactZone, ...] = parameter(
        (),
        unit="",
        doc="further contact zones {stiffness [N/m], reach [m], friction}, each within the ranges of contact_*; "
        "their stiffnesses add up",
    )
    reserve: float = parameter(
        0.1,
        unit="1",
        minimum=0.0,
        maximum=0.5,
        doc="share of the limit that pressing leaves for sliding and retreat",
    )
    yield_start: float = parameter(
        1.0,
        unit="1",
        minimum=0.5,
        maximum=1.0,
        doc="share of the limit where yielding begins; 1 = only beyond it",
    )
    period: float = parameter(
        0.02,
        unit="s",
        minimum=1e-3,
        maximum=LONGEST_TTL,
        doc="T, longest time one command acts; sent as its ttl",
    )
    delay: float = parameter(
        0.02,
        unit="s",
        minimum=0.0,
        maximum=0.1,
        doc="d, from contact to sample plus from command to motion, at most",
    )
    lag: float = parameter(0.02, unit="s", minimum=0.0, maximum=0.5, doc="tau, lag of the robot's motion")
    payload_mass: float = parameter(
        0.0,
        unit="kg",
        minimum=0.0,
        maximum=20.0,
        doc="mass beyond the sensor; times max_acceleration it counts as force that no contact exerts. Not counted is "
        "its torque, mass x acceleration x distance of the centre of mass from the tool origin: keep that below the "
        "torque's error_bound, by a centre of mass close to the tool or a lower max_acceleration",
    )
    spring_stiffness: Vector6 = parameter(
        (40.0, 40.0, 40.0, 10.0, 10.0, 10.0),
        unit="N/m, Nm/rad",
        minimum=1e-2,
        maximum=1e5,
        doc="of the law stiffness",
    )
    max_linear: float = parameter(
        0.25, unit="m/s", minimum=1e-3, maximum=1.0, doc="largest speed of the tool origin"
    )
    max_angular: float = parameter(
        0.5, unit="rad/s", minimum=1e-3, maximum=3.0, doc="largest turning rate of the tool"
    )
    max_acceleration: Vector6 = parameter(
        (2.0, 2.0, 2.0, 2.5, 2.5, 2.5),
        unit="m/s2, rad/s2",
        minimum=0.01,
        maximum=1e4,
        doc="of speeding up, tool axes; slowing down is never limited",
    )

    def check(self) -> None:
        """Refuse zones beyond the ranges of the first one, which is given by ``contact_*``."""
        for index, zone in enumerate(self.zones):
            for name in ("stiffness", "reach", "friction"):
                declared = type(self).model_fields[f"contact_{name}"]
                check_range(f"zones[{index}].{name}", getattr(zone, name), declared)

    @property
    def contact_zones(self) -> tuple[ContactZone, ...]:
        """All zones: the one of the ``contact_*`` parameters first."""
        first = ContactZone(self.contact_stiffness, self.contact_reach, self.contact_friction)
        return (first, *self.zones)

    @property
    def horizon(self) -> float:
        """T + d + tau [s], from a sample until the command that it leads to has acted."""
        return self.period + self.delay + self.lag
