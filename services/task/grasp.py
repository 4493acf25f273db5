"""Whether the gripper holds the panel: by its width, its effort and its own word together, for a while."""

from __future__ import annotations

from services.task.parameters import TaskParameters
from services.task.timers import Sustained
from shared.messages import GripperState

VERIFIED_AFTER = 0.3  # [s] without a doubt
SETTLED_AFTER = 1.0  # [s] after that the pose becomes home: the preload of the closing has gone (carry 4)
SLIPPED_AFTER = 0.3  # [s] of the word that nothing is held


def grasp_doubts(gripper: GripperState | None, parameters: TaskParameters) -> list[str]:
    """Why the gripper, as far as it is known, may not hold the panel, in words; empty if it does."""
    if gripper is None:
        return ["state/gripper is silent"]
    reasons, thickness, effort = [], parameters.panel_thickness, parameters.grasp_effort
    if abs(gripper.opening - thickness) > parameters.grasp_width:
        reasons.append(f"it is {gripper.opening * 1e3:.0f} mm wide, the panel {thickness * 1e3:.0f} mm")
    if abs(gripper.effort) < effort:
        reasons.append(f"its effort is {abs(gripper.effort):.1f} N, wanted are {effort:g} N")
    if not gripper.holding:
        reasons.append("it says that it holds nothing")
    return reasons


class GraspWatch:
    """A grasp over time: verified while ``grasp_doubts`` stay empty, lost only by the gripper's own word."""

    def __init__(self) -> None:
        self._verified = Sustained(VERIFIED_AFTER)
        self._settled = Sustained(SETTLED_AFTER)
        self._slipped = Sustained(SLIPPED_AFTER)

    def settled(self, reasons: list[str], dt: float) -> bool:
        """Whether the grasp is verified, and has been for a second."""
        return self._settled.update(self._verified.update(not reasons, dt), dt)

    def slipped(self, gripper: GripperState | None, dt: float) -> bool:
        """Whether what was held has been lost; not to know is no loss, and finds nothing again."""
        return self._slipped.update(not gripper.holding, dt) if gripper else self._slipped.reached

    def forget(self) -> None:
        """Nothing is held that could be lost."""
        self._slipped.reset()
