"""What can be wrong at work: a row each, name -> kind -> sentence. The state machine looks at kinds only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Kind(Enum):
    """What a fault takes away, the more fundamental first."""

    STOPPED = "stopped"
    """Somebody or something decided that the robot has to stand still."""
    LOST = "lost"
    """Where the tool is is not known."""
    NUMB = "numb"
    """There is no external wrench to trust."""
    UNTARED = "untared"
    """The wrench still contains the gripper's weight."""
    PARALYSED = "paralysed"
    """The controller does not follow its target."""
    UNSURE = "unsure"
    """Whether the gripper holds is not known."""
    LOOSE = "loose"
    """The gripper does not hold what it should."""
    BLIND = "blind"
    """There is no marker pose to trust."""


FAULTS: dict[str, tuple[Kind, str]] = {
    "stop": (Kind.STOPPED, "stop is engaged ({}): `tandem resume` releases it"),
    "robot_stopped": (Kind.STOPPED, "the robot is stopped ({})"),
    "robot_restarted": (Kind.STOPPED, "the robot process was restarted: holding where it is now"),
    "internal": (Kind.STOPPED, "a step of the task failed ({}): please report it"),
    "tool": (Kind.LOST, "the tool's pose is not known: {}"),
    "wrench_never": (Kind.NUMB, "waiting for wrench/external: never received. Is wrench running?"),
    "wrench_silent": (Kind.NUMB, "wrench/external is {}. Is wrench running?"),
    "wrench_invalid": (Kind.NUMB, "wrench/external is marked invalid ({}): look at the sensor"),
    "untared": (
        Kind.UNTARED,
        "nothing was tared: ask for it with `tandem tare`, or better with `tandem identify`, nothing touching the tool",
    ),
    "unidentified": (
        Kind.UNTARED,
        "a tare does not hold for a turned gripper, as `compensation` demands: `tandem identify` weighs it",
    ),
    "controller_never": (
        Kind.PARALYSED,
        "waiting for control/status: never received. Is controller running?",
    ),
    "controller_silent": (Kind.PARALYSED, "control/status is {}. Is controller running?"),
    "controller_braking": (Kind.PARALYSED, "the controller brakes ({})"),
    "gripper_silent": (
        Kind.UNSURE,
        "state/gripper is silent or marked invalid. Is the robot process running?",
    ),
    "slipped": (
        Kind.LOOSE,
        "the gripper says that it does not hold the panel any more: `reset` begins anew",
    ),
    "camera_never": (Kind.BLIND, "waiting for sensor/camera: never received. Is the camera on?"),
    "camera_silent": (Kind.BLIND, "no image for {}. Is the camera on?"),
    "camera_broken": (Kind.BLIND, "the camera's image is of no use: {}"),
    "marker_missing": (Kind.BLIND, "no marker in sight: is it covered, or out of the picture?"),
    "marker_other": (Kind.BLIND, "only other markers in sight: {}"),
    "marker_twice": (Kind.BLIND, "more than one marker of that number: {}; cover the others"),
    "marker_error": (
        Kind.BLIND,
        "the marker's corners fit no square of its size: {}. Bent, half covered, blurred?",
    ),
    "marker_ambiguous": (Kind.BLIND, "the marker may be tilted either way: {}. Look at it from another side"),
    "marker_jump": (Kind.BLIND, "the marker jumped by {}"),
    "marker_old": (Kind.BLIND, "the camera lags: its image is {}"),
    "marker_new": (Kind.BLIND, "the marker was seen in {}"),
}


@dataclass(frozen=True)
class Present:
    """A fault that is present: the name of its row, and what fills the sentence's gap."""

    name: str
    detail: str = ""

    @property
    def kind(self) -> Kind:
        """What it takes away."""
        return FAULTS[self.name][0]

    @property
    def sentence(self) -> str:
        """One sentence for the human: what, how much, what is allowed, the remedy."""
        return FAULTS[self.name][1].format(self.detail or "no reason given")
