"""How much motion can change the wrench: bounds on the stiffness of every contact that the user declares.

A contact at ``r`` from the tool's origin adds ``-J' K J`` to dw/dx, with ``J = [I, -[r]x]`` and any K of the declared
stiffness and friction. The bounds below hold element by element, for every such K and every sum of them
(docs/guarantee.md, "The stiffness bound").
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import mul

import numpy as np

from services.controller.zone import ContactZone
from shared.spatial import Array

TURN_QUANTUM = 0.006
"""Rotation [rad] that a bound is widened by beyond what is needed now, so that it can be used for some ticks."""

_NEXT = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def widened(reach: Sequence[float], turn: float) -> tuple[float, float, float]:
    """Reach (3,) [m] that holds while everything turns by at most ``turn`` [rad] about each axis, in any order.

    ``|Q| <= exp(turn (1 1' - I))`` element by element for any such rotation Q; this is that exponential, whose
    eigenvalues are ``exp(2 turn)`` along 1 and ``exp(-turn)`` across it.
    """
    shrink = math.exp(-turn)
    spread = (math.exp(2.0 * turn) - shrink) / 3.0 * (reach[0] + reach[1] + reach[2])
    return (shrink * reach[0] + spread, shrink * reach[1] + spread, shrink * reach[2] + spread)


def add_elastic(E: list[list[float]], low: list[float], zone: ContactZone, r: Sequence[float]) -> None:
    """Add one zone with reach ``r`` (3,) in base axes to the bounds E (6, 6) and low (6,) [N/m, N/rad, Nm/rad].

    ``E_ij = kappa/2 max(m |J_i||J_j| + |J_i.J_j| + mu |J_i x J_j|)``, ``low_i = kappa/2 (m - 1)|J_i|^2``,
    both attained at the corner of the reach because every term grows with |r|.
    """
    mu, m = zone.friction, zone.amplification
    half = 0.5 * zone.stiffness
    h = (math.hypot(r[1], r[2]), math.hypot(r[2], r[0]), math.hypot(r[0], r[1]))
    n = math.sqrt(r[0] ** 2 + r[1] ** 2 + r[2] ** 2)
    for i, j, k in _NEXT:
        E[i][i] += half * (m + 1.0)
        E[i + 3][i + 3] += half * (m + 1.0) * h[i] ** 2
        low[i] += half * (m - 1.0)
        low[i + 3] += half * (m - 1.0) * h[i] ** 2
        own = half * (m + mu) * h[i]  # force i, rotation i
        E[i][i + 3] += own
        E[i + 3][i] += own
        for a, b, c in ((i, j, k), (i, k, j)):
            E[a][b] += half * (m + mu)
            lever = half * (m * h[b] + r[c] + mu * r[a])  # force a, rotation b
            E[a][b + 3] += lever
            E[b + 3][a] += lever
            E[a + 3][b + 3] += half * (m * h[a] * h[b] + r[a] * r[b] + mu * n * r[c])


def geometric(force: Sequence[float], r: Sequence[float]) -> list[list[float]]:
    """Bound G (6, 6) on what turning and shifting the arm of existing forces adds, whatever the stiffness.

    Args:
        force: (3,) [N] bound on the sum of all contacts' forces, axis by axis.
        r: (3,) [m] reach in base axes.
    """
    G = [[0.0] * 6 for _ in range(6)]
    for i, j, k in _NEXT:
        G[i + 3][i + 3] = r[j] * force[j] + r[k] * force[k]
        for a, b, c in ((i, j, k), (i, k, j)):
            G[a][b + 3] = G[b + 3][a] = force[c]
            G[a + 3][b + 3] = max(r[a] * force[b], r[b] * force[a])
    return G


class StiffnessBound:
    """Kbar = E + G in base axes for the present attitude of the tool, recomputed only when it has to be.

    Attributes:
        matrix: Kbar (6, 6), bound on |dw_i/dx_j| [N/m, N/rad, Nm/m, Nm/rad].
        low: (6,), the most that moving along +i can raise w_i, per unit of travel.
        rows: Kbar as lists, for scalar arithmetic; ``roots`` (6,) are the square roots of its diagonal.
        geometric_rows: G (6, 6) as lists.
        reaches: reach (3,) [m] of each zone in base axes, widened.
        version: counts the recomputations.
    """

    def __init__(self, zones: Sequence[ContactZone]) -> None:
        if not zones:
            raise ValueError("a stiffness bound needs at least one contact zone")
        self.zones = tuple(zones)
        self.matrix = np.zeros((6, 6))
        self.low = np.zeros(6)
        self.rows: list[list[float]] = []
        self.roots: list[float] = []
        self.geometric_rows: list[list[float]] = []
        self.reaches: list[tuple[float, float, float]] = [(0.0, 0.0, 0.0)] * len(self.zones)
        self.version = 0
        self._rotation = np.full((3, 3), np.inf)
        self._turned = np.zeros((3, 3))
        self._difference = self._turned.ravel()
        self._force: list[float] = []
        self._turn = -1.0

    def update(self, rotation: Array, turn: float, force: list[float]) -> None:
        """Make the bound hold for a tool attitude and everything it can turn until the present command has acted.

        Args:
            rotation: (3, 3), tool to base.
            turn: [rad] bound on the rotation about each base axis, in flight and to come.
            force: (3,) [N] bound on the sum of the contacts' forces in base axes.
        """
        difference = self._difference
        np.subtract(rotation, self._rotation, self._turned)
        # |R - Rc|_F = 2 sqrt(2) sin(angle/2); the factor 0.72 > 1/sqrt(2) keeps the angle's bound above the angle
        # up to half a radian, and a larger difference always recomputes.
        square = float(difference.dot(difference))
        needed = turn + (0.72 * math.sqrt(square) if square < 0.1 else math.inf)
        if needed <= self._turn < needed + 2.0 * TURN_QUANTUM and self._force == force:
            return
        self._recompute(rotation, turn, force)

    def _recompute(self, rotation: Array, turn: float, force: list[float]) -> None:
        self._rotation = rotation.copy()
        self._turn = turn + TURN_QUANTUM
        self._force = force
        E = [[0.0] * 6 for _ in range(6)]
        low = [0.0] * 6
        rows = np.abs(rotation).tolist()
        farthest = [0.0, 0.0, 0.0]
        for index, zone in enumerate(self.zones):
            r = widened([sum(map(mul, row, zone.reach)) for row in rows], self._turn)
            self.reaches[index] = r
            farthest = [max(pair) for pair in zip(farthest, r, strict=True)]
            add_elastic(E, low, zone, r)
        self.geometric_rows = geometric(force, farthest)
        self.matrix[:] = E
        self.matrix += self.geometric_rows
        self.rows = self.matrix.tolist()
        self.roots = [math.sqrt(self.rows[i][i]) for i in range(6)]
        # G has no sign: moving along +i can raise w_i by G_ii too.
        self.low[:] = low
        self.low += [self.geometric_rows[i][i] for i in range(6)]
        self.version += 1
