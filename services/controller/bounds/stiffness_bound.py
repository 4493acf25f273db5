"""How much motion can change the wrench: bounds on the stiffness of every contact that the user declares.

A contact at ``r`` from the tool's origin adds ``-J' K J`` to dw/dx, with ``J = [I, -[r]x]`` and any K of the declared
stiffness and friction. The bounds below hold element by element, for every such K and every sum of them
(docs/guarantee.md, "The stiffness bound").
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from services.controller.bounds.contact_zone import ContactZone
from shared.spatial import Array

TURN_QUANTUM = 0.006
"""Rotation [rad] that a bound is widened by beyond what is needed now, so that it can be used for some ticks."""

_NEXT = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
_ONE, _R, _H, _N = 0, (1, 2, 3), (4, 5, 6), 7
"""The lengths that a zone's bounds are made of: 1, the reach r, its distances h from the axes, its norm n."""
_OFF_AXIS = np.array(((0.0, 1.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0)))
"""Takes the squares of r to those of h and n."""
_SAME_AXIS = np.eye(3)


def widened(reach: ArrayLike, turn: float) -> Array:
    """Reach (3,) or (3, n) [m] that holds while everything turns by at most ``turn`` [rad] about each axis.

    In any order: ``|Q| <= exp(turn (1 1' - I))`` element by element for any such rotation Q; this is that exponential,
    whose eigenvalues are ``exp(2 turn)`` along 1 and ``exp(-turn)`` across it.
    """
    shrink = math.exp(-turn)
    return (shrink * _SAME_AXIS + (math.exp(2.0 * turn) - shrink) / 3.0).dot(reach)


def elastic(zone: ContactZone) -> Array:
    """One zone's bounds as quadratic forms (7, 6, 8, 8) of its lengths 1, r, h, n [N/m, N/rad, Nm/rad].

    First E (6, 6), then low (6,): ``E_ij = kappa/2 max(m |J_i||J_j| + |J_i.J_j| + mu |J_i x J_j|)`` and
    ``low_i = kappa/2 (m - 1)|J_i|^2``, attained at the corner of the reach because every term grows with |r|.
    """
    mu, m = zone.friction, zone.amplification
    E = np.zeros((7, 6, 8, 8))
    low = E[6]
    for i, j, k in _NEXT:
        E[i, i, _ONE, _ONE] = E[i + 3, i + 3, _H[i], _H[i]] = m + 1.0
        low[i, _ONE, _ONE] = low[i + 3, _H[i], _H[i]] = m - 1.0
        E[i, i + 3, _ONE, _H[i]] = E[i + 3, i, _ONE, _H[i]] = m + mu  # force i, rotation i
        for a, b, c in ((i, j, k), (i, k, j)):
            E[a, b, _ONE, _ONE] = m + mu
            for lever in (E[a, b + 3, _ONE], E[b + 3, a, _ONE]):  # force a, rotation b
                lever[_H[b]], lever[_R[c]], lever[_R[a]] = m, 1.0, mu
            torque = E[a + 3, b + 3]
            torque[_H[a], _H[b]], torque[_R[a], _R[b]], torque[_N, _R[c]] = m, 1.0, mu
    return 0.5 * zone.stiffness * E


def _geometric() -> Array:
    """G (6, 6), then its diagonal (6,), as linear forms (42, 9) of what ``arms`` calculates."""
    G = np.zeros((7, 6, 9))
    for i, j, k in _NEXT:
        G[i + 3, i + 3, 6 + i] = G[6, i + 3, 6 + i] = 1.0
        for a, b, c in ((i, j, k), (i, k, j)):
            G[a, b + 3, c] = G[b + 3, a, c] = G[a + 3, b + 3, 3 + c] = 1.0
    return G.reshape((42, 9))


_GEOMETRIC = _geometric()


def arms(force: Sequence[float], r: Sequence[float]) -> tuple[float, ...]:
    """What turning and shifting the arm of existing forces adds to the stiffness, whatever the contacts' own.

    ``F_k`` (3,) [N]; ``max(r_i F_j, r_j F_i)`` and ``r_i F_i + r_j F_j`` (3,) [Nm], of the two axes other than k: the
    elements ``X_ij``, ``P_ij`` and ``P_kk`` of ``G = [0, X; X, P]``.

    Args:
        force: (3,) [N] bound on the sum of all contacts' forces, axis by axis.
        r: (3,) [m] reach in base axes.
    """
    (x, y, z), (fx, fy, fz) = r, force
    xx, yy, zz = x * fx, y * fy, z * fz
    crossed = (max(y * fz, z * fy), max(z * fx, x * fz), max(x * fy, y * fx))
    return (fx, fy, fz, *crossed, yy + zz, zz + xx, xx + yy)


class StiffnessBound:
    """Kbar = E + G in base axes for the present attitude of the tool, recomputed only when it has to be.

    Attributes:
        matrix: Kbar (6, 6), bound on |dw_i/dx_j| [N/m, N/rad, Nm/m, Nm/rad].
        low: (6,), the most that moving along +i can raise w_i, per unit of travel; G has no sign, so it counts too.
        rows: Kbar as lists, for scalar arithmetic; ``roots`` (6,) are the square roots of its diagonal.
        reaches: reach (3,) [m] of each zone in base axes, widened, as lists.
        version: counts the recomputations.
    """

    def __init__(self, zones: Sequence[ContactZone]) -> None:
        if not zones:
            raise ValueError("a stiffness bound needs at least one contact zone")
        self.zones = tuple(zones)
        count = len(self.zones)
        self._bounds = np.zeros(42)
        self.matrix, self.low = self._bounds[:36].reshape((6, 6)), self._bounds[36:]
        self.rows: list[list[float]] = []
        self.roots: list[float] = []
        self.reaches: list[list[float]] = []
        self._declared = np.array([zone.reach for zone in self.zones]).T.copy()
        # Only the lengths and the arms depend on the attitude: all elements are linear in the arms and in those
        # products of two lengths that occur.
        forms = np.stack([elastic(zone) for zone in self.zones], axis=-1).reshape((42, 64, count))
        pairs, which = np.nonzero(forms.any(axis=0))
        self._forms = np.hstack((forms[:, pairs, which], _GEOMETRIC))
        self._pairs = count * (pairs // 8) + which, count * (pairs % 8) + which
        self._lengths = np.ones((8, count))
        self._terms = np.zeros(len(pairs) + 9)
        self._products, self._arms = self._terms[:-9], self._terms[-9:]
        self.version = 0
        self._rotation = np.full((3, 3), np.inf)
        self._turned = np.zeros((3, 3))
        self._difference = self._turned.ravel()
        self._force: list[float] = []
        self._turn = -1.0

    @property
    def geometric_rows(self) -> list[list[float]]:
        """G (6, 6) as lists."""
        return _GEOMETRIC[:36].dot(self._arms).reshape((6, 6)).tolist()

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
        lengths = self._lengths
        r = widened(np.abs(rotation).dot(self._declared), self._turn)
        lengths[1:4] = r
        np.sqrt(_OFF_AXIS.dot(r * r), out=lengths[4:])
        first, second = self._pairs
        np.multiply(lengths.take(first), lengths.take(second), out=self._products)
        self._arms[:] = arms(force, [max(axis) for axis in r.tolist()])
        self._forms.dot(self._terms, self._bounds)
        self.reaches = r.T.tolist()
        self.rows = self.matrix.tolist()
        self.roots = np.sqrt(self.matrix.diagonal()).tolist()
        self.version += 1

    def largest(self, axes: Sequence[int], scale: Sequence[float]) -> float:
        """Bound on the largest eigenvalue of ``x^-1 K x^-1`` on some axes, over all contacts that are declared.

        Per zone ``kappa m lambda_max(J_P x_P^-2 J_P')`` at the corner of the reach: the eigenvalue is convex in r, and
        the corners differ by reflections, which leave it unchanged. The geometric part G adds its largest row sum.
        """
        weight = [1.0 / scale[i] ** 2 if i in axes else 0.0 for i in range(6)]
        ax, ay, az, bx, by, bz = weight
        total = 0.0
        for zone, (x, y, z) in zip(self.zones, self.reaches, strict=True):
            total += (
                zone.stiffness
                * zone.amplification
                * _largest_eigenvalue(
                    ax + by * z * z + bz * y * y,
                    ay + bx * z * z + bz * x * x,
                    az + bx * y * y + by * x * x,
                    -bz * x * y,
                    -by * x * z,
                    -bx * y * z,
                )
            )
        G = self.geometric_rows
        return total + max(sum(G[i][j] / scale[j] for j in axes) / scale[i] for i in axes)


def _largest_eigenvalue(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> float:
    """Largest eigenvalue of a symmetric 3x3 matrix, in closed form (the trigonometric solution of its cubic)."""
    off = xy * xy + xz * xz + yz * yz
    mean = (xx + yy + zz) / 3.0
    dx, dy, dz = xx - mean, yy - mean, zz - mean
    spread = math.sqrt((dx * dx + dy * dy + dz * dz + 2.0 * off) / 6.0)
    if spread <= 1e-12 * mean:
        return mean + spread
    determinant = dx * (dy * dz - yz * yz) - xy * (xy * dz - yz * xz) + xz * (xy * yz - dy * xz)
    cosine = min(1.0, max(-1.0, determinant / (2.0 * spread**3)))
    return mean + 2.0 * spread * math.cos(math.acos(cosine) / 3.0)
