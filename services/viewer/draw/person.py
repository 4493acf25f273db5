"""A simulated person as simple shapes, behind the place where it holds the panel: limbs between joints."""

from __future__ import annotations

import numpy as np
import rerun as rr

from shared.spatial import Array

THIGH, SHIN, TRUNK, UPPER_ARM, FOREARM = 0.44, 0.44, 0.48, 0.30, 0.32
"""Lengths [m]."""
_SHOULDER, _HIP, _HAND, _FOOT = 0.19, 0.11, 0.17, 0.13
"""Half the distance [m] between shoulders, hips, hands on the panel, and feet."""
_DISTANCE = 0.36
"""From the hands to the feet [m]."""
_TALL, _CROUCHING = 0.95, 0.48  # height of the hips [m]
_UPRIGHT, _BENT = 0.12, 0.85  # of the trunk, from the vertical [rad]
_HIGH, _LOW = 0.9, 0.3  # heights [m] of the lower hand between which a person bends down
_SHIRT, _TROUSERS, _SKIN, _SHOES = (41, 120, 128), (64, 74, 97), (204, 161, 133), (60, 60, 66)
_SIDE = ((0.075, _TROUSERS), (0.06, _TROUSERS), (0.05, _SHOES), (0.12, _SHIRT), (0.05, _SHIRT), (0.042, _SKIN))
_LIMBS = (*(limb for limb in _SIDE for _ in range(2)), (0.075, _SHIRT), (0.05, _SKIN), (0.115, _SKIN))
"""Radius [m] and colour: thighs, shins, feet, halves of the trunk, upper arms and forearms in pairs; shoulders, neck,
head."""
_UP = np.array((0.0, 0.0, 1.0))


def style() -> rr.Capsules3D:
    """Thickness and colours, which stay."""
    radii, colours = zip(*_LIMBS, strict=True)
    return rr.Capsules3D.from_fields(radii=radii, colors=colours, fill_mode="solid")


def person(hands: Array, across: Array, outward: Array, holds: bool) -> rr.Capsules3D:
    """Somebody who stands there.

    Args:
        hands: middle of the panel's edge that it holds (3,) [m].
        across: unit vector (3,) along that edge.
        outward: level unit vector (3,) from the robot to the person.
        holds: with its hands on the panel; else its arms hang.
    """
    limbs = posture(hands, across, outward, holds)
    ways = limbs[:, 1] - limbs[:, 0]
    lengths = np.linalg.norm(ways, axis=1)
    along = ways / lengths[:, None]
    # A capsule lies along z; the turn from there to where the limb points, as a quaternion.
    turns = np.column_stack((-along[:, 1], along[:, 0], np.zeros(len(along)), 1.0 + along[:, 2]))
    turns[along[:, 2] < -0.999999] = (1.0, 0.0, 0.0, 0.0)
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    return rr.Capsules3D.from_fields(lengths=lengths, translations=limbs[:, 0], quaternions=turns)


def posture(hands: Array, across: Array, outward: Array, holds: bool) -> Array:
    """Both ends (n, 2, 3) [m] of each limb; of each pair the left one, as seen from the robot, comes first."""
    left = np.cross(_UP, outward)
    sides = np.array((left, -left))
    lowest = hands[2] - _HAND * abs(across[2])
    bent = float(np.clip((_HIGH - lowest) / (_HIGH - _LOW), 0.0, 1.0)) if holds else 0.0
    lean = _UPRIGHT + (_BENT - _UPRIGHT) * bent
    ground = hands * (1.0, 1.0, 0.0) + _DISTANCE * outward
    middle = ground + 0.1 * bent * outward + (_TALL + (_CROUCHING - _TALL) * bent) * _UP
    neck = middle + TRUNK * (np.cos(lean) * _UP - np.sin(lean) * outward)
    ankles, hips, shoulders = ground + _FOOT * sides + 0.08 * _UP, middle + _HIP * sides, neck + _SHOULDER * sides
    palms = hands + _HAND * np.array((across, -across)) if holds else middle + 0.28 * sides - 0.08 * _UP
    knees = [_between(hip, ankle, THIGH, SHIN, -outward) for hip, ankle in zip(hips, ankles, strict=True)]
    elbows = [
        _between(shoulder, palm, UPPER_ARM, FOREARM, side - 2.0 * _UP)
        for shoulder, palm, side in zip(shoulders, palms, sides, strict=True)
    ]
    feet = [(ankle - 0.03 * _UP, ankle - 0.03 * _UP - 0.14 * outward) for ankle in ankles]
    trunk = [(middle + 0.4 * (hip - middle), neck + 0.4 * (hip - middle)) for hip in hips]
    head = neck + 0.22 * _UP - 0.1 * np.sin(lean) * outward
    legs = zip((*hips, *knees), (*knees, *ankles), strict=True)
    arms = zip((*shoulders, *elbows), (*elbows, *palms), strict=True)
    return np.array([*legs, *feet, *trunk, *arms, tuple(shoulders), (neck, head), (head, head + 0.001 * _UP)])


def _between(start: Array, end: Array, upper: float, lower: float, towards: Array) -> Array:
    """The joint (3,) [m] between two links of those lengths [m] that bends in a direction."""
    way = end - start
    span = float(np.clip(np.linalg.norm(way), 1e-6, upper + lower))
    along = way / np.linalg.norm(way)
    first = (upper**2 - lower**2 + span**2) / (2.0 * span)
    aside = towards - towards.dot(along) * along
    return start + first * along + np.sqrt(max(0.0, upper**2 - first**2)) * aside / np.linalg.norm(aside)
