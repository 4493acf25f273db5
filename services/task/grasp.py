"""Whether the gripper holds the panel: by its width, its effort and its own word together, for a while."""

from __future__ import annotations

from services.task.timers import Held
from shared.messages import GripperState

VERIFIED_AFTER = 0.3  # [s]
SETTLED_AFTER = 1.0
"""Time [s] after the verified closing at which the pose becomes home: the preload of the closing has gone (CARRY 4)."""
SLIPPED_AFTER = 0.3  # [s]


def doubts(gripper: GripperState, thickness: float, tolerance: float, effort: float) -> list[str]:
    """Why the gripper may not hold the panel, in words.

    Args:
        gripper: as it says it is.
        thickness: of the panel [m].
        tolerance: of the opening [m].
        effort: that a grasp shows at least [N].
    """
    reasons = []
    if abs(gripper.opening - thickness) > tolerance:
        reasons.append(f"it is {gripper.opening * 1e3:.0f} mm wide, the panel {thickness * 1e3:.0f} mm")
    if abs(gripper.effort) < effort:
        reasons.append(f"its effort is {abs(gripper.effort):.1f} N, wanted are {effort:g} N")
    if not gripper.holding:
        reasons.append("it says that it holds nothing")
    return reasons


class GraspWatch:
    """Verified by ``doubts`` staying empty; lost again only by the gripper's own word, for as long."""

    def __init__(self) -> None:
        self._verified = Held(VERIFIED_AFTER)
        self._settled = Held(SETTLED_AFTER)
        self._slipped = Held(SLIPPED_AFTER)

    def settled(self, reasons: list[str], dt: float) -> bool:
        """Whether the grasp is verified, and has been for a second."""
        return self._settled.update(self._verified.update(not reasons, dt), dt)

    def slipped(self, gripper: GripperState | None, dt: float) -> bool:
        """Whether what was held has been lost; not to know is no loss, and finds nothing again."""
        return self._slipped.update(not gripper.holding, dt) if gripper else self._slipped.reached

    def forget(self) -> None:
        """Nothing is held that could be lost."""
        self._slipped.reset()
