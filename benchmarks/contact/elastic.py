"""Elastic laws of a single contact point: springs, surfaces with friction, constant loads.

A law gives the force on a point as a function of the point's path, in axes in which the law stands still. Without
friction the force is the gradient of an elastic energy. Arrays along a path have the path's n samples as their first
dimension.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from shared.spatial import Array


class ElasticLaw(Protocol):
    """Force on a point as a function of its path, in the axes of the law."""

    def forces(self, path: Array, memory: Memory) -> Array:
        """Forces (n, 3) [N] on the point along its path (n, 3) [m]; brings ``memory`` to the path's end."""
        ...

    def probe(self, points: Array, memory: Memory) -> Array:
        """Forces (n, 3) [N] after moving straight to each of ``points`` (n, 3) [m]; leaves ``memory`` alone."""
        ...

    @property
    def stiffness(self) -> float:
        """The largest stiffness [N/m], normal or tangential, anywhere."""
        ...


@dataclass
class Memory:
    """What a contact remembers: where its point was [m] and the friction force [N] there."""

    point: Array
    friction: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Spring:
    """Two-sided linear spring, ``f = -matrix (q - rest)``.

    Attributes:
        matrix: (3, 3) symmetric, positive semidefinite [N/m].
        rest: (3,) where the force vanishes [m].
    """

    matrix: Array
    rest: Array

    def forces(self, path: Array, memory: Memory) -> Array:
        return self.probe(path, memory)

    def probe(self, points: Array, memory: Memory) -> Array:
        return (self.rest - points) @ self.matrix

    @property
    def stiffness(self) -> float:
        return float(np.linalg.eigvalsh(self.matrix)[-1])


@dataclass(frozen=True)
class Surface:
    """A plane with a normal stiffness and Coulomb friction, as an incremental law.

    The tangential force follows an elastic stick law and is returned radially to the cone ``|t| <= friction |N|`` when
    it leaves it. One-sided surfaces push only; two-sided ones (a gripped rail) also pull.

    Attributes:
        normal: (3,) unit vector out of the surface.
        origin: (3,) a point of the plane [m].
        normal_stiffness: [N/m].
        tangential_stiffness: while sticking [N/m].
        friction: coefficient, 0 for none.
        two_sided: whether it pulls as well.
    """

    normal: Array
    origin: Array
    normal_stiffness: float
    tangential_stiffness: float = 0.0
    friction: float = 0.0
    two_sided: bool = False

    def forces(self, path: Array, memory: Memory) -> Array:
        pressing = self._pressing(path)
        result = pressing[:, None] * self.normal
        if self.friction > 0.0:
            steps = np.diff(path, axis=0, prepend=memory.point[None])
            result += self._slide(self._sideways(steps), self.friction * np.abs(pressing), memory)
        memory.point = path[-1]
        return result

    def probe(self, points: Array, memory: Memory) -> Array:
        pressing = self._pressing(points)
        result = pressing[:, None] * self.normal
        if self.friction > 0.0:
            steps = self._sideways(points - memory.point)
            trial = memory.friction - self.tangential_stiffness * steps
            size = np.maximum(np.linalg.norm(trial, axis=1), 1e-12)
            result += trial * np.minimum(1.0, self.friction * np.abs(pressing) / size)[:, None]
        return result

    def _pressing(self, points: Array) -> Array:
        depth = (self.origin - points) @ self.normal
        return self.normal_stiffness * (depth if self.two_sided else np.maximum(depth, 0.0))

    def _sideways(self, steps: Array) -> Array:
        return steps - (steps @ self.normal)[:, None] * self.normal

    def _slide(self, steps: Array, cone: Array, memory: Memory) -> Array:
        x, y, z = memory.friction.tolist()
        result = []
        for (dx, dy, dz), most in zip((steps * self.tangential_stiffness).tolist(), cone.tolist(), strict=True):
            x, y, z = x - dx, y - dy, z - dz
            size = math.sqrt(x * x + y * y + z * z)
            if size > most:
                scale = most / size
                x, y, z = x * scale, y * scale, z * scale
            result.append((x, y, z))
        memory.friction = np.array(result[-1])
        return np.array(result)

    @property
    def stiffness(self) -> float:
        return max(self.normal_stiffness, self.tangential_stiffness if self.friction > 0.0 else 0.0)


@dataclass(frozen=True)
class Load:
    """A constant force (3,) [N], such as a hanging weight on a carried point."""

    force: Array
    stiffness: float = 0.0

    def forces(self, path: Array, memory: Memory) -> Array:
        return self.probe(path, memory)

    def probe(self, points: Array, memory: Memory) -> Array:
        return np.tile(self.force, (len(points), 1))
