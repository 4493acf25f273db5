"""Made-up motions of a carry: what is not said rests at the origin, level."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from services.experiment.carry.motion import Motion
from shared.spatial import Array


def along(way: Array) -> Array:
    """A way (n,) along x, as vectors (n, 3)."""
    return np.outer(way, (1.0, 0.0, 0.0))


def motion(time: Array, **series: Any) -> Motion:
    """The motion at times (n,) [s], with some series given; the person guides all the time."""
    rest, level = np.zeros((len(time), 3)), np.tile(np.eye(3), (len(time), 1, 1))
    still = dict.fromkeys(("panel", "hand", "wish", "push", "twist", "base", "tool"), rest)
    axes = dict.fromkeys(("panel_axes", "wish_axes", "tool_axes"), level)
    fixed = {"time": time, "sampled": time, "doing": np.full(len(time), "move")}
    return Motion(**(fixed | still | axes | series))


def guided(time: Array, base: Array, hand: Array, axes: Rotation, tool: Array) -> Motion:
    """Somebody who holds the panel at `hand` (n, 3), its axes as given; the tool rests (3,); all of that in base axes.

    The hands push with 2 N along x and twist with 3 Nm about z of the world.
    """
    heading = Rotation.from_rotvec(np.outer(base[:, 2], (0.0, 0.0, 1.0)))
    planted = base[:, :2] @ np.eye(2, 3)
    place, turned = planted + heading.apply(hand), (heading * axes).as_matrix()
    return motion(
        time,
        **{"panel_axes": turned, "wish_axes": turned, "hand": place, "wish": place, "base": base},
        push=np.tile((2.0, 0.0, 0.0), (len(time), 1)),
        twist=np.tile((0.0, 0.0, 3.0), (len(time), 1)),
        tool=planted + heading.apply(np.tile(tool, (len(time), 1))),
        tool_axes=heading.as_matrix(),
    )
