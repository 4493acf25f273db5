"""A short made-up carry, as the film's recording has it."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.sim.robot.kinematics import CARRY_HOME
from shared.spatial import quaternion_from_vector

ROWS, SECONDS = 41, 4.0
START = (1.17, -0.39, 0.78)
"""Of the panel's centre [m], on its trestles."""


def carry(**changes: Any) -> dict[str, Any]:
    """The base drives half a metre sideways while the panel is lifted, and then turned upright."""
    share = np.linspace(0.0, 1.0, ROWS)
    aside, lift = 0.5 * share, 0.2 * np.clip(3.0 * share, 0.0, 1.0)
    panel = START + np.column_stack((0.0 * share, aside, lift))
    turns = np.clip(2.0 * share - 1.0, 0.0, 1.0) * np.pi / 2.0
    data = {
        "scene": "carry",
        "parameters": {"scene": "carry", "marker_id": 7, "marker_size": 0.15},
        "time": np.linspace(10.0, 10.0 + SECONDS, ROWS),
        "joint_names": np.array(list(CARRY_HOME)),
        "joint_positions": np.tile(list(CARRY_HOME.values()), (ROWS, 1)),
        "base": np.column_stack((0.0 * share, aside, 0.0 * share)),
        "panel_position": panel,
        "panel_orientation": np.array([quaternion_from_vector((turn, 0.0, 0.0)) for turn in turns]),
        "hand_position": panel + np.array((0.57, 0.0, 0.0)),
        "hand_force": np.tile((0.0, 2.0, 8.0), (ROWS, 1)),
        "person_holds": share > 0.1,
        "force": np.tile((0.0, 2.0, -8.0), (ROWS, 1)),
        "wrench": np.tile((0.0, 2.0, -1.0, 0.1, 0.0, -4.0), (ROWS, 1)),
        "limit": np.tile((10.0, 10.0, 10.0, 0.5, 3.0, 3.0), (ROWS, 1)),
        "covered": share > 0.2,
        "looking": share < 0.2,
        "caption": np.array(["lifted"] * ROWS),
        "moment_times": np.array((10.0, 12.0, 14.0)),
        "moment_captions": np.array(("found", "lifted", "turned upright")),
    }
    return {name: value for name, value in (data | changes).items() if value is not None}
