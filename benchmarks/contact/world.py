"""The contact world: elastic point contacts between a tool that moves in SE(3) and its surroundings.

Everything is quasi-static: the wrench is a function of the path of poses, never of speed. A contact is a point that
belongs to one side and an elastic law that belongs to the other: *carried* points are fixed in the tool and press on an
environment whose axes do not turn; the others are fixed in the environment and press on a face that turns with the
tool. Both conserve energy without friction, because the force is the gradient of an elastic energy of the point's
position in the axes of the law. Arrays along a path have the path's n samples as their first dimension.
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

    @property
    def stiffness(self) -> float:
        """The largest stiffness [N/m], normal or tangential, anywhere."""
        ...


@dataclass
class Memory:
    """What a contact remembers: where its point was [m] and the friction force [N] there."""

    point: Array
    friction: Array = field(default_factory=lambda: np.zeros(3))

    def copy(self) -> Memory:
        """An independent copy."""
        return Memory(self.point.copy(), self.friction.copy())


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
        """See ``ElasticLaw``."""
        memory.point = path[-1]
        return (self.rest - path) @ self.matrix

    @property
    def stiffness(self) -> float:
        """See ``ElasticLaw``."""
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
        """See ``ElasticLaw``."""
        depth = (self.origin - path) @ self.normal
        pressing = self.normal_stiffness * (depth if self.two_sided else np.maximum(depth, 0.0))
        result = pressing[:, None] * self.normal
        if self.friction > 0.0:
            steps = np.diff(path, axis=0, prepend=memory.point[None])
            steps = steps - (steps @ self.normal)[:, None] * self.normal
            result += self._friction(steps, self.friction * np.abs(pressing), memory)
        memory.point = path[-1]
        return result

    def _friction(self, steps: Array, cone: Array, memory: Memory) -> Array:
        x, y, z = memory.friction.tolist()
        result = []
        for (dx, dy, dz), most in zip(
            (steps * self.tangential_stiffness).tolist(), cone.tolist(), strict=True
        ):
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
        """See ``ElasticLaw``."""
        return max(self.normal_stiffness, self.tangential_stiffness if self.friction > 0.0 else 0.0)


@dataclass(frozen=True)
class Load:
    """A constant force (3,) [N], such as a hanging weight on a carried point."""

    force: Array
    stiffness: float = 0.0

    def forces(self, path: Array, memory: Memory) -> Array:
        """See ``ElasticLaw``."""
        return np.tile(self.force, (len(path), 1))


@dataclass(frozen=True)
class Contact:
    """One point contact.

    Attributes:
        point: (3,) [m], in tool axes from the tool origin if ``carried``, else in base axes.
        carried: whether the point moves with the tool and the law stands still, or the other way round.
        law: the elastic law, in base axes if ``carried``, else in tool axes.
    """

    point: Array
    carried: bool
    law: ElasticLaw


class World:
    """All contacts together, with their memory and what the assumptions about them ask to be watched.

    Attributes:
        reach: (3,) farthest loaded contact seen from the tool origin, tool axes [m].
        squeeze: (3,) largest sum over the contacts of the force's magnitude per base axis [N].
    """

    def __init__(self, contacts: tuple[Contact, ...], position: Array, rotation: Array) -> None:
        """Starts with the tool at ``position`` (3,) [m] and ``rotation`` (3, 3), without friction forces."""
        self.contacts = contacts
        self.reach = np.zeros(3)
        self.squeeze = np.zeros(3)
        start = position[None], rotation[None], np.zeros((1, 3))
        self._memory = [Memory(_local(contact, *start)[0]) for contact in contacts]

    def advance(self, positions: Array, rotations: Array, shift: Array) -> Array:
        """Wrench (n, 6) on the tool about its origin, base axes [N, Nm], along a path of poses.

        Args:
            positions: (n, 3) of the tool origin [m].
            rotations: (n, 3, 3) tool to base.
            shift: (n, 3) how far the environment has moved [m].
        """
        result = np.zeros((len(positions), 6))
        sizes = np.zeros((len(positions), 3))
        for contact, memory in zip(self.contacts, self._memory, strict=True):
            force, arm = _on_tool(contact, memory, positions, rotations, shift)
            result[:, :3] += force
            result[:, 3:] += _cross(arm, force)
            sizes += np.abs(force)
            loaded = np.any(force != 0.0, axis=1)
            if loaded.any():
                arms = np.abs(np.einsum("nji,nj->ni", rotations[loaded], arm[loaded]))
                self.reach = np.maximum(self.reach, arms.max(axis=0))
        self.squeeze = np.maximum(self.squeeze, sizes.max(axis=0))
        return result

    def stiffness(self, position: Array, rotation: Array, shift: Array, step: float = 1e-7) -> Array:
        """The present tangent ``-dw/dx`` (6, 6), geometry included, by one-sided differences of ``step`` [m, rad]."""
        moves = np.vstack((np.zeros(6), step * np.eye(6)))
        wrenches = []
        for move in moves:
            turned = _small_rotation(move[3:]) @ rotation
            total = np.zeros(6)
            pose = (position + move[:3])[None], turned[None], shift[None]
            for contact, memory in zip(self.contacts, self._memory, strict=True):
                force, arm = _on_tool(contact, memory.copy(), *pose)
                total[:3] += force[0]
                total[3:] += _cross(arm, force)[0]
            wrenches.append(total)
        return -(np.array(wrenches[1:]) - wrenches[0]).T / step


def _local(contact: Contact, positions: Array, rotations: Array, shift: Array) -> Array:
    """Path (n, 3) of the contact's point in the axes of its law."""
    if contact.carried:
        return positions + rotations @ contact.point - shift
    return np.einsum("nji,nj->ni", rotations, contact.point + shift - positions)


def _on_tool(
    contact: Contact, memory: Memory, positions: Array, rotations: Array, shift: Array
) -> tuple[Array, Array]:
    """Force on the tool and its lever arm from the tool origin, both (n, 3) in base axes."""
    force = contact.law.forces(_local(contact, positions, rotations, shift), memory)
    if contact.carried:
        return force, rotations @ contact.point
    # The law acts on the environment's point; the tool feels the reaction.
    return -np.einsum("nij,nj->ni", rotations, force), contact.point + shift - positions


def _cross(a: Array, b: Array) -> Array:
    """Row by row cross product of (n, 3) and (n, 3): a third of the time of numpy's general one."""
    return a[:, (1, 2, 0)] * b[:, (2, 0, 1)] - a[:, (2, 0, 1)] * b[:, (1, 2, 0)]


def _small_rotation(vector: Array) -> Array:
    x, y, z = vector.tolist()
    half = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    return np.eye(3) + half + half @ half / 2.0
