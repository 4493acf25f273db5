"""A film of a recorded run, rendered by the simulator in a process of its own: services never import each other."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

from services.experiment.recording import RECORDING, Recording
from shared import topics

FILM = "scene.mp4"
PATIENCE = 300.0  # [s]


def render(folder: Path) -> str:
    """Renders the run in `folder` to FILM beside its recording; returns why there is none, empty if there is.

    Raises:
        FileNotFoundError: there is no recording.
        KeyError: the recording lacks what the film shows.
    """
    source, film = folder / "film.npz", folder / FILM
    film_data(Recording.load(folder / RECORDING), source)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "services.sim.film", str(source), str(film)],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"rendering took over {PATIENCE:.0f} s"
    finally:
        source.unlink(missing_ok=True)
    if done.returncode == 0 and film.exists():
        return ""
    said = (done.stderr.strip() or done.stdout.strip() or "it said nothing").splitlines()[-1]
    return f"services.sim.film ended with status {done.returncode}: {said}"


def film_data(recording: Recording, path: Path) -> None:
    """Writes what `services.sim.film` reads: joint angles, bag and load on the joints' time base."""
    joints, world, wrench = topics.STATE_JOINTS.key, topics.SIM_WORLD.key, topics.WRENCH_EXTERNAL.key
    time = recording.time(joints)
    shown = time >= 0
    time = time[shown]
    bag_time = recording.time(world)
    newest = np.clip(np.searchsorted(bag_time, time, side="right") - 1, 0, len(bag_time) - 1)
    np.savez_compressed(
        path,
        time=time,
        joint_names=recording.series(joints, "name")[0],
        joint_positions=recording.series(joints, "position")[shown],
        bag_mass=np.nan_to_num(recording.series(world, "bag.mass")[newest]),
        bag_height=recording.series(world, "bag.height")[newest],
        force_z=np.interp(time, recording.time(wrench), recording.series(wrench, "force")[:, 2]),
        limit_z=np.full(len(time), recording.meta["force_limit"][2]),
    )
