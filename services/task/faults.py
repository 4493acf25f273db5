"""What can be wrong at work: a row each, by the kind of impairment. The state machine looks at kinds only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Impairment(Enum):
    """What a fault takes away, the more fundamental first."""

    STOPPED = "stopped"
    """Somebody or something decided that the robot has to stand still."""
    LOST = "lost"
    """The tool's pose is not known."""
    NUMB = "numb"
    """There is no external wrench to trust."""
    UNTARED = "untared"
    """The wrench still contains the gripper's weight, or the sensor's zero."""
    STALE = "stale"
    """The sensor's zero is so old that little of the limits is left."""
    PARALYSED = "paralysed"
    """The controller does not follow its target."""
    UNSURE = "unsure"
    """Whether the gripper holds is not known."""
    LOOSE = "loose"
    """The gripper does not hold what it should."""
    BLIND = "blind"
    """There is no marker pose to trust."""


_SENTENCES = {
    Impairment.STOPPED: {
        "stop": "stop is engaged ({}): `tandem resume` releases it",
        "robot_stopped": "the robot is stopped ({})",
        "robot_restarted": "the robot process was restarted: holding where it is now",
        "internal": "a step of the task failed ({}): please report it",
    },
    Impairment.LOST: {"tool": "the tool's pose is not known: {}"},
    Impairment.NUMB: {
        "wrench_never": "waiting for wrench/external: never received. Is wrench running?",
        "wrench_silent": "wrench/external is {}. Is wrench running?",
        "wrench_refused": "{}",
        "wrench_invalid": "wrench/external is marked invalid ({}): look at the sensor",
    },
    Impairment.UNTARED: {
        "untared": "nothing was tared: ask for it with `tandem tare`, or better with `tandem identify`, nothing "
        "touching the tool",
        "no_zero": "there is no zero of the sensor from this run of the robot process: `tandem tare`, nothing touching "
        "the tool",
        "unidentified": "a tare does not hold for a turned gripper, as `compensation` demands: `tandem identify` "
        "weighs it",
    },
    Impairment.STALE: {"zero_old": "the zero is {}: let go of the tool and `tandem tare`"},
    Impairment.PARALYSED: {
        "controller_never": "waiting for control/status: never received. Is controller running?",
        "controller_silent": "control/status is {}. Is controller running?",
        "controller_refused": "{}",
        "target_taken": "{} publishes control/target and was first: end it where it runs, then the task moves the arm",
        "controller_braking": "the controller brakes ({})",
    },
    Impairment.UNSURE: {
        "gripper_never": "state/gripper was never received. Is the robot process running?",
        "gripper_silent": "state/gripper is {}. Is the robot process running?",
        "gripper_refused": "{}",
        "gripper_invalid": "state/gripper is marked invalid by its publisher",
    },
    Impairment.LOOSE: {"slipped": "the gripper says that it does not hold the panel any more: `reset` begins anew"},
    Impairment.BLIND: {
        "camera_never": "waiting for sensor/camera: never received. Is the camera on?",
        "camera_silent": "no image for {}. Is the camera on?",
        "camera_slow": "images come {}: set a higher rate in the camera's driver, or a longer `marker_max_age`",
        "camera_refused": "{}",
        "camera_invalid": "the camera's image is marked invalid: look at the camera",
        "camera_broken": "the camera's image cannot be read: {}",
        "camera_model": "the camera's calibration is of no use: {}",
        "camera_blank": "the picture shows nothing ({}): lens covered, dark, too bright?",
        "camera_repeats": "the picture stays the same to the last byte, as a frozen camera's does: let the head turn, "
        "or give a simulated camera noise",
        "camera_frozen": "the camera is frozen: it shows the same {}. Start it anew",
        "camera_still": "the head was told to turn, and the camera's pose has not changed {}: a frozen camera, or a "
        "head that does not move?",
        "camera_wrong": "what is told about the camera or the marker is wrong: in other places of the picture the "
        "marker is elsewhere by {}",
        "marker_missing": "no marker in sight: is it covered, or out of the picture?",
        "marker_other": "only other markers in sight: {}",
        "marker_twice": "more than one marker of that number: {}; cover the others",
        "marker_mirrored": "the picture is mirrored: {} stands in it as in a mirror. Turn that off in its driver",
        "marker_edges": "the marker's edges are not to be seen along their length: half covered, too small, blurred?",
        "marker_error": "the marker's corners fit no square: {}. Bent, half covered, or another picture's calibration?",
        "marker_ambiguous": "the marker may be tilted either way: both fit, {}. Look at it from another side",
        "marker_unproven": "the camera is not yet proven: the marker was seen in {}",
        "marker_moved": "the panel was moved {}: it has to rest while the head looks at it",
        "marker_jump": "the marker jumped by {}",
        "marker_old": "the camera lags: its image is {}",
        "marker_new": "the marker was seen in {}",
    },
}
FAULTS: dict[str, tuple[Impairment, str]] = {
    name: (kind, sentence) for kind, rows in _SENTENCES.items() for name, sentence in rows.items()
}
"""What each fault takes away, and the sentence for the human; {} is filled in with what is the case and the limit."""


@dataclass(frozen=True)
class TaskFault:
    """A fault that is present: the name of its row, and what fills the sentence's gap."""

    name: str
    detail: str = ""

    @property
    def kind(self) -> Impairment:
        """What it takes away."""
        return FAULTS[self.name][0]

    @property
    def sentence(self) -> str:
        """One sentence for the human: what, how much, what is allowed, the remedy."""
        return FAULTS[self.name][1].format(self.detail or "no reason given")
