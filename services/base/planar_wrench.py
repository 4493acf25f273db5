"""The external wrench as the base feels it: two forces and the torque about the vertical through the base's origin."""

from __future__ import annotations

import math
from collections.abc import Sequence

Planar = tuple[float, float, float]
"""Elements along x, along y and about z in base axes, about the base's origin: [N, N, Nm] or [m/s, m/s, rad/s]."""


def about_base(force: Sequence[float], torque: Sequence[float], position: Sequence[float]) -> Planar:
    """``(fx, fy, tau_z + x fy - y fx)`` [N, N, Nm], the wrench about the base's origin.

    Args:
        force: (3,) [N] in base axes.
        torque: (3,) [Nm] about the tool's origin, in base axes.
        position: (3,) [m] of the tool in base.
    """
    fx, fy, _ = force
    x, y, _ = position
    return fx, fy, torque[2] + x * fy - y * fx


def error_about_base(error_bound: Sequence[float], position: Sequence[float]) -> Planar:
    """Largest error of ``about_base`` [N, N, Nm] while the wrench at the tool is within its bound.

    Args:
        error_bound: (6,) [N, Nm] at the tool.
        position: (3,) [m] of the tool in base.
    """
    ex, ey, _, _, _, ez = error_bound
    x, y, _ = position
    return ex, ey, ez + abs(x) * ey + abs(y) * ex


def beyond_dead_band(wrench: Planar, band: Planar) -> Planar:
    """The part of each element beyond its dead band; continuous, so that a wrench at the edge causes no jerks.

    Args:
        wrench: [N, N, Nm].
        band: half-width of the dead band of each element, not negative.
    """
    fx, fy, tz = (
        math.copysign(max(0.0, abs(element) - half), element) for element, half in zip(wrench, band, strict=True)
    )
    return fx, fy, tz
