"""What the film of the carry shows, for `services.sim.film.film`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from services.experiment.carry.story import LOOKING, Story
from services.experiment.play.recording import Recording
from shared import topics


def film_data(recording: Recording, path: Path) -> None:
    """Writes what `services.sim.film.film` reads, everything on the time base of `sim/world`.

    Raises:
        KeyError: the recording lacks what the film shows.
    """
    world, joints, base = topics.SIM_WORLD.key, topics.STATE_JOINTS.key, topics.STATE_BASE.key
    wrench, target = topics.WRENCH_EXTERNAL.key, topics.CONTROL_TARGET.key
    time = recording.time(world)
    time = time[time >= 0]

    def now(key: str, *names: str) -> np.ndarray:
        """The newest values of fields at each time, side by side."""
        newest = np.searchsorted(recording.time(key), time, side="right") - 1
        fields = [recording.series(key, name)[np.maximum(newest, 0)] for name in names]
        return fields[0] if len(fields) == 1 else np.column_stack(fields)

    state = now(topics.TASK_STATUS.key, "state")
    hands, panel = now(world, "hand.position"), now(world, "panel.orientation")
    story = Story(time, state, now(world, "hand.doing"), hands, panel)
    limit = now(target, "force_limit", "torque_limit")
    limit[time < recording.time(target)[0]] = np.nan
    covered = recording.event("covered")
    np.savez_compressed(
        path,
        scene="carry",
        parameters=json.dumps(recording.meta["settings"]["sim"]),
        time=time,
        joint_names=recording.series(joints, "name")[0],
        joint_positions=now(joints, "position"),
        base=now(base, "position", "yaw"),
        panel_position=now(world, "panel.position"),
        panel_orientation=panel,
        hand_position=hands,
        hand_force=now(world, "hand.force"),
        person_holds=story.holds,
        force=now(wrench, "force"),
        wrench=now(wrench, "force", "torque") - now(target, "nominal_force", "nominal_torque"),
        limit=limit,
        covered=time >= (np.inf if covered is None else covered.time),
        looking=np.isin(state, LOOKING),
        caption=story.captions,
        moment_times=[moment for moment, _ in story.moments],
        moment_captions=[caption for _, caption in story.moments],
    )
