"""What the film of the load experiment shows, for `services.sim.film.film`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from services.experiment.play.recording import Recording
from shared import topics


def film_data(recording: Recording, path: Path) -> None:
    """Writes what `services.sim.film.film` reads: joint angles, bag and load on the joints' time base.

    Raises:
        KeyError: the recording lacks what the film shows.
    """
    joints, world, wrench = topics.STATE_JOINTS.key, topics.SIM_WORLD.key, topics.WRENCH_EXTERNAL.key
    time = recording.time(joints)
    shown = time >= 0
    time = time[shown]
    bag_time = recording.time(world)
    newest = np.clip(np.searchsorted(bag_time, time, side="right") - 1, 0, len(bag_time) - 1)
    np.savez_compressed(
        path,
        scene="load",
        time=time,
        joint_names=recording.series(joints, "name")[0],
        joint_positions=recording.series(joints, "position")[shown],
        bag_mass=np.nan_to_num(recording.series(world, "bag.mass")[newest]),
        bag_height=recording.series(world, "bag.height")[newest],
        force_z=np.interp(time, recording.time(wrench), recording.series(wrench, "force")[:, 2]),
        limit_z=np.full(len(time), recording.meta["force_limit"][2]),
    )
