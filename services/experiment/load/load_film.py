"""What the film of the load experiment shows, as `services/sim/film/load_film.py` reads it."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.experiment.play.recording import Recording
from shared import topics


def film_data(recording: Recording) -> dict[str, Any]:
    """Joint angles, bag and load on the joints' time base.

    Raises:
        KeyError: the recording lacks what the film shows.
    """
    joints, world, wrench = topics.STATE_JOINTS.key, topics.SIM_WORLD.key, topics.WRENCH_EXTERNAL.key
    time = recording.time(joints)
    shown = time >= 0
    time = time[shown]
    return {
        "scene": "load",
        "time": time,
        "joint_names": recording.series(joints, "name")[0],
        "joint_positions": recording.series(joints, "position")[shown],
        "bag_mass": np.nan_to_num(recording.newest(world, time, "bag.mass")),
        "bag_height": recording.newest(world, time, "bag.height"),
        "force_z": np.interp(time, recording.time(wrench), recording.series(wrench, "force")[:, 2]),
        "limit_z": np.full(len(time), recording.meta["force_limit"][2]),
    }
