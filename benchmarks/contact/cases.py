"""One case of the contact benchmark: everything that happens in it, and what is declared to the controller about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.contact.world import Contact
from shared.spatial import Array


@dataclass(frozen=True)
class Timing:
    """How samples and commands travel, and what is declared about it.

    Attributes:
        period: nominal control period [s].
        jitter: share of the period by which each one may be longer or shorter.
        delay: shortest and longest time from a sample to its command acting [s].
        latency: age of a sample when the controller sees it [s].
        lag: time constant of the robot [s].
        declared_period: `period` of the controller, the longest time that one command acts [s].
        declared_delay: `delay` of the controller, latency included [s].
        declared_lag: `lag` of the controller [s].
    """

    period: float
    jitter: float
    delay: tuple[float, float]
    latency: float
    lag: float
    declared_period: float
    declared_delay: float
    declared_lag: float


@dataclass(frozen=True)
class Declared:
    """What is declared about contacts and robot, by the names of the controller's parameters."""

    contact_stiffness: float
    contact_reach: tuple[float, float, float]
    contact_friction: float
    relaxation_weight: float
    max_linear: float
    max_angular: float
    max_acceleration: tuple[float, ...]


@dataclass(frozen=True)
class Target:
    """A target pose that comes into force at ``time`` [s]: position (3,) [m], rotation (3, 3)."""

    time: float
    position: Array
    rotation: Array


@dataclass(frozen=True)
class Case:
    """One run's script.

    Attributes:
        group: name of the set that it belongs to.
        seed: what its random numbers during the run start from.
        position: tool at the start (3,) [m].
        rotation: tool at the start (3, 3).
        contacts: the world.
        limit: (6,) [N, Nm].
        error_bound: (6,) [N, Nm].
        nominal: (6,) what the tool carries by agreement [N, Nm].
        timing: periods, delays and lag.
        declared: what the controller is told.
        adversary: kind of measurement error, see ``adversary.KINDS``.
        error: (6,) the error of kind "constant" [N, Nm]; drawn if None.
        targets: in order of time.
        shift_times: (n,) [s] of the environment's way points.
        shift: (n, 3) [m], how far it has moved there.
        quiet: time [s] from which on errors, targets and environment stand still.
        duration: [s].
    """

    group: str
    seed: int
    position: Array
    rotation: Array
    contacts: tuple[Contact, ...]
    limit: Array
    error_bound: Array
    nominal: Array
    timing: Timing
    declared: Declared
    adversary: str
    targets: tuple[Target, ...]
    shift_times: Array
    shift: Array
    quiet: float
    duration: float
    error: Array | None = None

    def moved(self, times: Array) -> Array:
        """How far the environment has moved (n, 3) [m] at ``times`` (n,) [s]."""
        return np.stack([np.interp(times, self.shift_times, column) for column in self.shift.T], axis=1)

    @property
    def at_rest(self) -> bool:
        """Whether the environment stands still throughout."""
        return not self.shift.any()

    def target(self, time: float) -> Target:
        """The target in force at ``time`` [s]."""
        return [target for target in self.targets if target.time <= time][-1]
