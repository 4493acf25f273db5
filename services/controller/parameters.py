"""The controller's parameters."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from services.controller.contact import ContactZone
from shared.parameters import Parameters, Refused, Vector3, Vector6, parameter

LawName = Literal["certified", "paper", "stiffness"]

LARGEST_TTL = 0.2
"""Longest time to live [s] of a command that the contract allows."""


class Zone(BaseModel):
    """A further contact zone of the configuration file, ``[[controller.zones]]``."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    stiffness: float = Field(ge=1.0, le=1e7, description="kappa [N/m], sum over all contacts of the zone")
    reach: Vector3 = Field(description="farthest contact from the tool origin [m], tool axes")
    friction: float = Field(default=0.0, ge=0.0, le=2.0, description="mu [1]")


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
    zones: tuple[Zone, ...] = Field(default=(), description="further contact zones, their stiffness adds up")
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
        maximum=LARGEST_TTL,
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
        doc="mass beyond the sensor; times max_acceleration it is no contact",
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
        """Refuse zones that are no boxes; single numbers are checked by their ranges."""
        for index, zone in enumerate(self.zones):
            if not all(1e-3 <= length <= 5.0 for length in zone.reach):
                raise Refused(f"zones[{index}].reach is {list(zone.reach)}, allowed is 0.001 to 5 m per axis")

    @property
    def contact_zones(self) -> tuple[ContactZone, ...]:
        """All zones: the one of the ``contact_*`` parameters first."""
        first = ContactZone(self.contact_stiffness, self.contact_reach, self.contact_friction)
        return (first, *(ContactZone(zone.stiffness, zone.reach, zone.friction) for zone in self.zones))

    @property
    def horizon(self) -> float:
        """T + d + tau [s], from a sample until the command that it leads to has acted."""
        return self.period + self.delay + self.lag
