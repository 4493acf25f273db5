"""What happens in a carry, part by part: as figures name it, and as its film says it."""

from __future__ import annotations

import math
from collections.abc import Iterable

from services.experiment.carry.carry_measures import changes, task_states
from services.experiment.carry.carry_protocol import GUIDANCE
from services.experiment.carry.following import Followed, followed
from services.experiment.carry.motion import Motion
from services.experiment.play.recording import Recording
from services.viewer.take import Part

# Name in figures, caption in the film, name of the still of its end: "" for none.
STATES = {
    "idle": ("", "the robot opens its gripper", ""),
    "calibrating": ("", "the robot stands still: nothing may touch its gripper yet", ""),
    "searching": ("", "the robot looks for the marker on the panel", "marker found"),
    "approaching": ("", "its gripper goes to the panel's edge", ""),
    "grasping": ("grasp", "the gripper closes on the panel", "grasped"),
    "carrying": ("", "the robot holds its end", ""),
    "releasing": ("release", "the robot feels the ground carry the panel, and lets go", ""),
    "retreating": ("", "the gripper is open and goes back", ""),
    "done": ("", "the panel has been set down", "set down"),
    "holding": ("", "the robot holds still: somebody has to decide", ""),
}
_DOINGS = {
    "take_hold": ("", "the person takes hold of the far end", ""),
    "lift": ("lift", "both lift the panel", "lifted"),
    "lower": ("lower", "both set the panel down on its edge", ""),
    "let_go": ("let go", "", ""),
}
_MOVEMENTS = {
    "pull": ("the person pulls: the robot follows", "pulled"),
    "push": ("the person pushes: the robot gives way", ""),
    "left": ("the person leads the panel sideways", "led sideways"),
    "right": ("the person leads it back", ""),
    "twist": ("the person twists the panel", "twisted"),
    "twist back": ("the person turns it back", ""),
    "turn": ("the person turns the panel upright", "turned upright"),
}
Begun = Iterable[tuple[str, float]]
"""Words, each with the time [s] at which it began."""


def parts(states: Begun, doings: Begun, movements: Iterable[Followed], end: float) -> list[Part]:
    """All of them in order of time.

    Args:
        states: of the task.
        doings: of the person.
        movements: by which the person guided the robot.
        end: of the last state and the last doing [s].
    """
    found = [Part(one.name, one.start, one.end, *_MOVEMENTS[one.name]) for one in movements if math.isfinite(one.start)]
    for begun, words in ((states, STATES), (doings, _DOINGS)):
        times = list(begun)
        for (word, start), (_, until) in zip(times, [*times[1:], ("", end)], strict=True):
            if word in words and until > start:
                name, caption, still = words[word]
                found.append(Part(name, start, until, caption, still))
    return sorted(found, key=lambda part: part.start)


def recorded_parts(recording: Recording) -> list[Part]:
    """Those of a recording, of one that was given up as far as it went.

    Raises:
        KeyError, ValueError: it lacks what they are told from.
    """
    motion, (states, _) = Motion.of(recording), task_states(recording)
    movements = followed(motion, GUIDANCE[str(recording.meta["name"]).rpartition("-")[2]])
    return parts(states, changes(motion.time, motion.doing), movements, float(motion.time[-1]))
