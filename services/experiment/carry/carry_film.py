"""What the film of the carry shows, as `services/sim/film/carry_recording.py` reads it."""

from __future__ import annotations

from typing import Any

import numpy as np

from services.experiment.carry.story import LOOKING, Story
from services.experiment.play.recording import Recording
from shared import topics


def film_data(recording: Recording) -> dict[str, Any]:
    """Everything on the time base of `sim/world`.

    Raises:
        KeyError: the recording lacks what the film shows.
    """
    world, joints, base = topics.SIM_WORLD.key, topics.STATE_JOINTS.key, topics.STATE_BASE.key
    wrench, target = topics.WRENCH_EXTERNAL.key, topics.CONTROL_TARGET.key
    time = recording.time(world)
    time = time[time >= 0]
    state = recording.newest(topics.TASK_STATUS.key, time, "state")
    doing = recording.newest(world, time, "hand.doing")
    hands = recording.newest(world, time, "hand.position")
    panel = recording.newest(world, time, "panel.orientation")
    story = Story(time, state, doing, hands, panel)
    limit = recording.newest(target, time, "force_limit", "torque_limit")
    limit[time < recording.time(target)[0]] = np.nan
    nominal = recording.newest(target, time, "nominal_force", "nominal_torque")
    covered = recording.event("covered")
    return {
        "scene": "carry",
        "parameters": recording.meta["settings"]["sim"],
        "time": time,
        "joint_names": recording.series(joints, "name")[0],
        "joint_positions": recording.newest(joints, time, "position"),
        "base": recording.newest(base, time, "position", "yaw"),
        "panel_position": recording.newest(world, time, "panel.position"),
        "panel_orientation": panel,
        "hand_position": hands,
        "hand_force": recording.newest(world, time, "hand.force"),
        "person_holds": story.holds,
        "force": recording.newest(wrench, time, "force"),
        "wrench": recording.newest(wrench, time, "force", "torque") - nominal,
        "limit": limit,
        "covered": time >= (np.inf if covered is None else covered.time),
        "looking": np.isin(state, LOOKING),
        "caption": story.captions,
        "moment_times": [moment for moment, _ in story.moments],
        "moment_captions": [caption for _, caption in story.moments],
    }
