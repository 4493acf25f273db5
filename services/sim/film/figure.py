"""A person suggested by simple shapes, who stands behind the panel's far edge and holds it with two hands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pybullet

from services.sim.camera.canvas import Canvas, Colour
from shared.spatial import Array

THIGH, SHIN, TRUNK, UPPER_ARM, FOREARM = 0.44, 0.44, 0.48, 0.30, 0.32
"""Lengths [m]."""
SHOULDER, HIP, HAND = 0.19, 0.11, 0.17
"""Half the distance [m] between shoulders, hips, and hands on the panel."""
DISTANCE = 0.36
"""From the hands to the feet [m]."""
_TALL, _CROUCHING = 0.95, 0.48  # height of the hips [m]
_UPRIGHT, _BENT = 0.12, 0.85  # of the trunk, from the vertical [rad]
_HIGH, _LOW = 0.9, 0.3  # heights [m] of the lower hand between which a person bends down
_SHIRT: Colour = (0.16, 0.47, 0.50, 1.0)
_TROUSERS: Colour = (0.25, 0.29, 0.38, 1.0)
_SKIN: Colour = (0.80, 0.63, 0.52, 1.0)
_SHOES: Colour = (0.16, 0.16, 0.18, 1.0)
_UP = np.array((0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Posture:
    """Where the joints are (3,) [m]; of each pair the one on the left of who looks from the robot comes first."""

    feet: Array
    knees: Array
    hips: Array
    shoulders: Array
    elbows: Array
    hands: Array
    head: Array


def posture(edge: Array, across: Array, outward: Array, holding: float) -> Posture:
    """How somebody stands there.

    Args:
        edge: middle of the panel's far edge (3,) [m].
        across: unit vector (3,) along that edge.
        outward: level unit vector (3,) from the robot to the person.
        holding: 1 with the hands on the panel, 0 with the arms hanging.
    """
    left = np.cross(_UP, outward)
    lowest = edge[2] - HAND * abs(across[2])
    bent = holding * float(np.clip((_HIGH - lowest) / (_HIGH - _LOW), 0.0, 1.0))
    lean = _UPRIGHT + (_BENT - _UPRIGHT) * bent
    ground = edge * (1.0, 1.0, 0.0) + DISTANCE * outward
    middle = ground + 0.1 * bent * outward + (_TALL + (_CROUCHING - _TALL) * bent) * _UP
    neck = middle + TRUNK * (np.cos(lean) * _UP - np.sin(lean) * outward)
    sides = np.array((left, -left))
    feet, hips, shoulders = ground + 0.13 * sides, middle + HIP * sides, neck + SHOULDER * sides
    hanging = middle + 0.28 * sides - 0.08 * _UP - 0.05 * outward
    hands = hanging + holding * (edge + HAND * np.array((across, -across)) - hanging)
    knees = [_between(hip, foot, THIGH, SHIN, -outward) for hip, foot in zip(hips, feet + 0.08 * _UP, strict=True)]
    elbows = [
        _between(shoulder, hand, UPPER_ARM, FOREARM, side - 2.0 * _UP)
        for shoulder, hand, side in zip(shoulders, hands, sides, strict=True)
    ]
    head = neck + 0.22 * _UP - 0.1 * np.sin(lean) * outward
    return Posture(feet, np.array(knees), hips, shoulders, np.array(elbows), hands, head)


def _between(start: Array, end: Array, upper: float, lower: float, towards: Array) -> Array:
    """The joint (3,) [m] between two links of those lengths [m] that bends in a direction."""
    way = end - start
    span = float(np.clip(np.linalg.norm(way), 1e-6, upper + lower))
    along = way / np.linalg.norm(way)
    first = (upper**2 - lower**2 + span**2) / (2.0 * span)
    aside = towards - towards.dot(along) * along
    return start + first * along + np.sqrt(max(0.0, upper**2 - first**2)) * aside / np.linalg.norm(aside)


class Figure:
    """The shapes of a person.

    Args:
        canvas: where they are drawn.
    """

    def __init__(self, canvas: Canvas) -> None:
        self._canvas = canvas
        self._legs = [self._limb(0.075, THIGH, _TROUSERS) for _ in range(2)]
        self._shins = [self._limb(0.06, SHIN, _TROUSERS) for _ in range(2)]
        self._arms = [self._limb(0.05, UPPER_ARM, _SHIRT) for _ in range(2)]
        self._forearms = [self._limb(0.042, FOREARM, _SKIN) for _ in range(2)]
        self._trunk = [self._limb(0.12, TRUNK, _SHIRT) for _ in range(2)]
        self._yoke = self._limb(0.075, 2.0 * SHOULDER, _SHIRT)
        self._neck = self._limb(0.05, 0.2, _SKIN)
        self._head = canvas.shape(pybullet.GEOM_SPHERE, _SKIN, radius=0.115)
        self._hands = [canvas.shape(pybullet.GEOM_SPHERE, _SKIN, radius=0.055) for _ in range(2)]
        self._shoes = [canvas.box((0.25, 0.1, 0.08), _SHOES) for _ in range(2)]

    def _limb(self, radius: float, length: float, colour: Colour) -> int:
        return self._canvas.shape(pybullet.GEOM_CAPSULE, colour, radius=radius, length=length)

    def pose(self, stance: Posture, outward: Array) -> None:
        """Put the shapes where the joints are; ``outward`` (3,) points from the robot to the person."""
        middle, neck = stance.hips.mean(axis=0), stance.shoulders.mean(axis=0)
        for side in range(2):
            self._link(self._legs[side], stance.hips[side], stance.knees[side])
            self._link(self._shins[side], stance.knees[side], stance.feet[side] + 0.08 * _UP)
            self._link(self._arms[side], stance.shoulders[side], stance.elbows[side])
            self._link(self._forearms[side], stance.elbows[side], stance.hands[side])
            self._canvas.place(self._hands[side], stance.hands[side])
            aside = 0.4 * (stance.hips[side] - middle)
            self._link(self._trunk[side], middle + aside, neck + aside)
            turned = np.column_stack((-outward, np.cross(_UP, -outward), _UP))
            self._canvas.place(self._shoes[side], stance.feet[side] + 0.04 * _UP - 0.05 * outward, turned)
        self._link(self._yoke, *stance.shoulders)
        self._link(self._neck, neck, stance.head)
        self._canvas.place(self._head, stance.head)

    def _link(self, body: int, start: Array, end: Array) -> None:
        """Put a limb between two points (3,) [m]."""
        along = (end - start) / np.linalg.norm(end - start)
        aside = np.cross(along, (0.31, 0.87, 0.38))
        aside /= np.linalg.norm(aside)
        rotation = np.column_stack((aside, np.cross(along, aside), along))
        self._canvas.place(body, 0.5 * (start + end), rotation)
