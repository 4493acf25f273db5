"""The contact world: elastic point contacts between a tool that moves in SE(3) and its surroundings.

Everything is quasi-static: the wrench is a function of the path of poses, never of speed. A contact is a point that
belongs to one side and an elastic law that belongs to the other: *carried* points are fixed in the tool and press on an
environment whose axes do not turn; the others are fixed in the environment and press on a face that turns with the
tool. Both conserve energy without friction, because the force is the gradient of an elastic energy of the point's
position in the axes of the law. Arrays along a path have the path's n samples as their first dimension.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.contact.elastic import ElasticLaw, Memory
from shared.spatial import Array


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
            force, arm = _act(contact, contact.law.forces, memory, positions, rotations, shift)
            _add(result, force, arm)
            sizes += np.abs(force)
            loaded = np.any(force != 0.0, axis=1)
            if loaded.any():
                arms = np.abs(np.einsum("nji,nj->ni", rotations[loaded], arm[loaded]))
                self.reach = np.maximum(self.reach, arms.max(axis=0))
        self.squeeze = np.maximum(self.squeeze, sizes.max(axis=0))
        return result

    def stiffness(self, position: Array, rotation: Array, shift: Array, step: float = 1e-7) -> Array:
        """The present tangent ``-dw/dx`` (6, 6), geometry included, by one-sided differences of ``step`` [m, rad]."""
        positions, rotations = np.tile(position, (7, 1)), np.tile(rotation, (7, 1, 1))
        positions[1:4] += step * np.eye(3)
        rotations[4:] = _TURNS @ rotation * step + rotation
        moved = np.tile(shift, (7, 1))
        wrenches = np.zeros((7, 6))
        for contact, memory in zip(self.contacts, self._memory, strict=True):
            _add(wrenches, *_act(contact, contact.law.probe, memory, positions, rotations, moved))
        return -(wrenches[1:] - wrenches[0]).T / step


def _local(contact: Contact, positions: Array, rotations: Array, shift: Array) -> Array:
    """Path (n, 3) of the contact's point in the axes of its law."""
    if contact.carried:
        return positions + rotations @ contact.point - shift
    return np.einsum("nji,nj->ni", rotations, contact.point + shift - positions)


def _act(
    contact: Contact,
    law: Callable[[Array, Memory], Array],
    memory: Memory,
    positions: Array,
    rotations: Array,
    shift: Array,
) -> tuple[Array, Array]:
    """Force on the tool and its lever arm from the tool origin, (n, 3) in base axes."""
    force = law(_local(contact, positions, rotations, shift), memory)
    if contact.carried:
        return force, rotations @ contact.point
    # The law acts on the environment's point; the tool feels the reaction.
    return -np.einsum("nij,nj->ni", rotations, force), contact.point + shift - positions


def _add(wrenches: Array, force: Array, arm: Array) -> None:
    """Add forces (n, 3) with their lever arms; numpy's own cross product takes many times as long."""
    wrenches[:, :3] += force
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        wrenches[:, 3 + i] += arm[:, j] * force[:, k] - arm[:, k] * force[:, j]


# Generators of the rotations about x, y and z.
_TURNS = -np.array(
    [[[0, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 0, -1], [0, 0, 0], [1, 0, 0]], [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]]
)
