"""The states of the carrying task, what a step of one sees and decides, and how each reacts to each kind of fault."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from services.task.faults import Kind, Present
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from shared.messages import GripperState
from shared.spatial import Array


class State(Enum):
    """In the order in which a carry goes through them; ``holding`` is reached from anywhere."""

    IDLE = "idle"
    CALIBRATING = "calibrating"
    SEARCHING = "searching"
    APPROACHING = "approaching"
    GRASPING = "grasping"
    CARRYING = "carrying"
    RELEASING = "releasing"
    RETREATING = "retreating"
    DONE = "done"
    HOLDING = "holding"


@dataclass(frozen=True, eq=False)
class Seen:
    """What is known at the instant of a step; None is what is not known or not to be trusted.

    Attributes:
        tool: in base.
        speed: of its origin [m/s].
        turning: its turning rate [rad/s].
        session: of the robot process.
        wrench: external force and torque (6,) [N, Nm] on the tool in base axes.
        gripper: its state.
        marker: the marker in base, from a fresh image.
        doubt: why there is no marker pose.
        guarded: whether a controller keeps the limits at this instant; the base must not follow while none does.
        robot: why the robot does not move as commanded, in its own words.
    """

    tool: Pose
    speed: float
    turning: float
    session: int
    wrench: Array | None = None
    gripper: GripperState | None = None
    marker: Pose | None = None
    doubt: Present | None = None
    guarded: bool = False
    robot: str = ""

    @property
    def force(self) -> float:
        """External force along base z [N].

        Raises:
            ValueError: it is not known. The states that ask wait for it; zero would be what lets a panel go.
        """
        if self.wrench is None:
            raise ValueError("the external wrench is not known")
        return float(self.wrench[2])


@dataclass(frozen=True)
class Grip:
    """A command to the gripper: opening [m] and effort [N]."""

    opening: float
    effort: float


@dataclass(frozen=True, eq=False)
class Decision:
    """What one step decides.

    Attributes:
        reason: one sentence for the human.
        target: pose of the tool; None keeps the last one.
        nominal: nominal force along base z [N].
        base: whether the base may follow.
        gripper: command; None sends none.
        head: pan and tilt [rad]; None sends none.
        after: the state to go on in.
    """

    reason: str
    target: Pose | None = None
    nominal: float = 0.0
    base: bool = False
    gripper: Grip | None = None
    head: tuple[float, float] | None = None
    after: State | None = None


_NOW, _PATIENCE, _MARKER, _FOREVER = "now", "patience", "marker_patience", "forever"
_MOVING = {Kind.STOPPED: _NOW, Kind.LOST: _PATIENCE, Kind.NUMB: _PATIENCE, Kind.PARALYSED: _PATIENCE}
_TARED = {**_MOVING, Kind.UNTARED: _NOW}
REACTIONS: dict[State, dict[Kind, str]] = {
    State.CALIBRATING: {
        **dict.fromkeys((Kind.NUMB, Kind.UNTARED, Kind.PARALYSED), _FOREVER),
        Kind.STOPPED: _NOW,
    },
    State.SEARCHING: _TARED,
    State.APPROACHING: {**_TARED, Kind.BLIND: _MARKER},
    State.GRASPING: _TARED,
    State.CARRYING: {**_TARED, Kind.UNSURE: _PATIENCE, Kind.LOOSE: _NOW},
    State.RELEASING: {**_TARED, Kind.UNSURE: _PATIENCE, Kind.LOOSE: _NOW},
    State.RETREATING: _MOVING,
}
"""How long each state stands still for each kind of fault before it gives up to holding; what is missing it ignores."""
HELD = (State.CARRYING, State.RELEASING, State.HOLDING)
"""States in which a panel that was grasped is in the gripper, or has slipped out of it."""
AT_REST = (State.IDLE, State.DONE)
"""States that want nothing of the robot."""


def patience(state: State, kind: Kind, parameters: TaskParameters) -> float | None:
    """Time [s] that a state waits for a fault to go away; None if it does not concern the state."""
    name = REACTIONS.get(state, {}).get(kind)
    if name is None:
        return None
    return {_NOW: 0.0, _FOREVER: math.inf}.get(name, getattr(parameters, name, 0.0))
