"""The states of the carrying task: what a step observes and decides, and how each state reacts to each fault."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from services.task.faults import Impairment, TaskFault
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from shared.messages import GripperCommand, GripperState
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


UNSURE = TaskFault("gripper_never")


@dataclass(frozen=True, eq=False)
class Observation:
    """What is known at the instant of a step; None is what is not known or not to be trusted.

    Attributes:
        tool: in base.
        speed: of its origin [m/s].
        turning: its turning rate [rad/s].
        session: of the robot process.
        wrench: external force and torque (6,) [N, Nm] on the tool in base axes.
        gripper: its state.
        unsure: why that is not known, where it is not.
        marker: the marker in base, from a fresh image.
        doubt: why there is no marker pose that may be gone by.
        proven: whether the camera has shown the marker in the same place of base from several views.
        turn: pan and tilt [rad] that the head has to turn for these views, from where it looks; None without a marker.
        nudge: the same [rad] for a picture that differs from the last one.
        guarded: whether a controller keeps the limits at this instant; the base must not follow while none does.
        robot: why the robot does not move as commanded, in its own words.
    """

    tool: Pose
    speed: float
    turning: float
    session: int
    wrench: Array | None = None
    gripper: GripperState | None = None
    unsure: TaskFault = UNSURE
    marker: Pose | None = None
    doubt: TaskFault | None = None
    proven: bool = False
    turn: tuple[float, float] | None = None
    nudge: float = 0.0
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
    gripper: GripperCommand | None = None
    head: tuple[float, float] | None = None
    after: State | None = None


_NOW, _PATIENCE, _MARKER, _FOREVER = "now", "patience", "marker_patience", "forever"
_MOVING = {
    Impairment.STOPPED: _NOW,
    **dict.fromkeys((Impairment.LOST, Impairment.NUMB, Impairment.PARALYSED), _PATIENCE),
}
_TARED = {**_MOVING, Impairment.UNTARED: _NOW}
_HOLDING = {**_TARED, Impairment.UNSURE: _PATIENCE, Impairment.LOOSE: _NOW}
REACTIONS: dict[State, dict[Impairment, str]] = {
    State.CALIBRATING: {
        Impairment.STOPPED: _NOW,
        **dict.fromkeys((Impairment.NUMB, Impairment.UNTARED, Impairment.STALE, Impairment.PARALYSED), _FOREVER),
    },
    State.SEARCHING: _TARED,
    State.APPROACHING: {**_TARED, Impairment.BLIND: _MARKER},
    State.GRASPING: _TARED,
    State.CARRYING: _HOLDING,
    State.RELEASING: _HOLDING,
    State.RETREATING: _MOVING,
}
"""How long a state stands still for a kind of fault before it gives up to holding; it ignores a kind not named here."""
WITH_PANEL = (State.CARRYING, State.RELEASING, State.HOLDING)
"""States in which a panel that was grasped is in the gripper, or has slipped out of it."""
AT_REST = (State.IDLE, State.DONE)
"""States that want nothing of the robot."""


def patience(state: State, kind: Impairment, parameters: TaskParameters) -> float | None:
    """Time [s] that a state waits for a fault to go away; None if it does not concern the state."""
    name = REACTIONS.get(state, {}).get(kind)
    if name is None:
        return None
    return {_NOW: 0.0, _FOREVER: math.inf}.get(name, getattr(parameters, name, 0.0))
