"""What the film of the carry shows, and what happens in words: as `services/sim/film/carry_recording.py` reads it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from services.experiment.play.recording import Recording
from shared import topics
from shared.spatial import Array

LOOKING = ("calibrating", "searching", "approaching")
"""States of the task in which it has the head camera on."""
STATES = {
    "idle": "The robot opens its gripper",
    "calibrating": "The robot stands still: nothing may touch its gripper yet",
    "searching": "The head camera looks for the marker on the panel",
    "approaching": "The marker is found: the gripper goes to the panel's edge",
    "grasping": "The gripper closes on the panel",
    "carrying": "The robot holds its end and waits for the person",
    "releasing": "The robot feels the ground carry the panel, and lets go",
    "retreating": "The gripper is open and goes back",
    "done": "Done: the panel has been set down",
    "holding": "The robot holds still: somebody has to decide",
}
DOINGS = {
    "take_hold": "The person takes hold of the far end; the marker is covered from now on",
    "lift": "Both lift the panel",
    "lower": "Both set the panel down on its edge",
}
"""What the person does while the robot carries; where the panel is led is seen from the panel."""
PULLS, PUSHES = "The person pulls: the robot follows", "The person pushes: the robot gives way"
LEADS, SIDEWAYS = "The person leads the panel", "The person leads the panel sideways"
TWISTS, TURNS = "The person twists the panel and turns it back", "The person turns the panel upright"
_SLOW = 0.02  # [m/s]
_SPAN = 0.5  # [s] over which the speed of the hands is taken
_LEVEL = np.radians(5.0)


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


class Story:
    """A carry, told from its series (N, ...).

    Attributes:
        captions: what happens, for each row.
        moments: times [s] and captions of stills.
        holds: whether the person holds the panel (N,).

    Args:
        time: of the rows (N,) [s].
        state: of the task (N,).
        doing: of the person (N,).
        hands: where the person's hands are (N, 3) [m], in world.
        orientation: of the panel (N, 4), in world.
    """

    def __init__(self, time: Array, state: np.ndarray, doing: np.ndarray, hands: Array, orientation: Array) -> None:
        self._time, self._state, self._doing, self._hands = time, state, doing, hands
        x, y, z, w = orientation.T
        self._roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        turning = doing == "turn"
        level = np.flatnonzero(turning & (np.abs(self._roll) < _LEVEL))
        # After it was level for the last time the turn is the one that lasts.
        self._twisting = turning & (np.arange(len(time)) <= (level[-1] if len(level) else -1))
        self.holds = np.maximum.accumulate(doing == "take_hold") & (doing != "")
        self.captions = list(self._told())
        self.moments = [(float(time[row]), caption) for row, caption in self._stills()]

    def _told(self) -> Iterator[str]:
        before, after = self._time - 0.5 * _SPAN, self._time + 0.5 * _SPAN
        velocity = np.column_stack(
            [np.interp(after, self._time, way) - np.interp(before, self._time, way) for way in self._hands.T]
        )
        velocity /= _SPAN
        leading = LEADS
        for state, doing, (vx, vy, _), twisting in zip(self._state, self._doing, velocity, self._twisting, strict=True):
            if state != "carrying":
                yield STATES.get(state, state)
            elif doing == "move":
                if max(abs(vx), abs(vy)) > _SLOW:
                    leading = SIDEWAYS if abs(vy) > abs(vx) else PULLS if vx > 0.0 else PUSHES
                yield leading
            elif doing == "turn":
                yield TWISTS if twisting else TURNS
            else:
                yield DOINGS.get(doing, STATES["carrying"])

    def _stills(self) -> Iterator[tuple[int, str]]:
        """Rows that show what happened, as far as it happened."""
        for state, caption in (("approaching", "marker found"), ("carrying", "grasped")):
            yield from ((row, caption) for row in np.flatnonzero(self._state == state)[:1])
        carried = self._state == "carrying"
        yield from ((row, "lifted") for row in np.flatnonzero(carried & (self._doing == "lift"))[-1:])
        moved = np.flatnonzero(carried & (self._doing == "move"))
        if len(moved):
            way = self._hands[moved] - self._hands[moved[0]]
            along, aside = np.abs(way[:, :2]).argmax(axis=0)
            caption = "pulled" if way[along, 0] > 0.0 else "pushed"
            yield from sorted(((moved[along], caption), (moved[aside], "led sideways")))
        twisted = np.flatnonzero(carried & self._twisting)
        if len(twisted):
            yield twisted[np.abs(self._roll[twisted]).argmax()], "twisted"
        turned = np.flatnonzero(carried & (self._doing == "turn") & ~self._twisting)
        yield from ((row, "turned upright") for row in turned[-1:])
        if self._state[-1] == "done":
            yield len(self._time) - 1, "set down"
