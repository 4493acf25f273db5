"""Level assist: the robot's end follows the person's end up and down (carry 2; not in the paper)."""

from __future__ import annotations

import math

from services.task.geometry import Pose
from shared.spatial import Array

DEAD_BAND = 0.015  # [m] of height difference that is left alone
FARTHEST = 0.3  # [m] of the target from the tool at most
RELAXATION = 0.02  # [m/s] at which the target comes back to the tool inside the dead band


def far_end_drop(tool: Pose, torque: Array, length: float, compliance: float) -> float:
    """How much lower than the tool the far end is, or is pressed [m]: o = L (sin pitch + c tau_n).

    Args:
        tool: the tool in base; positive pitch points its x axis, along which the panel extends, down.
        torque: external torque (3,) [Nm] on the tool in base axes.
        length: L [m], from the tool to the person's hands.
        compliance: c [rad/Nm].
    """
    _, pitch, yaw = tool.rpy.tolist()
    # n, the horizontal axis across the tool's x axis: a hand that presses the far end down turns about +n.
    across = -math.sin(yaw) * float(torque[0]) + math.cos(yaw) * float(torque[1])
    return length * (math.sin(pitch) + compliance * across)


class LevelAssist:
    """Height of the target z_hat = z_tool - clip(o, 0.3 m); inside the dead band z_hat relaxes to z_tool.

    It moves nothing but the target, so the force limits hold whatever it does.

    Args:
        share: 0 to 1 [1] of o that is used.
        height: of the target at first [m].
    """

    def __init__(self, share: float, height: float) -> None:
        self._share = share
        self.height = height

    def update(self, height: float, offset: float, dt: float) -> float:
        """Height of the target [m].

        Args:
            height: of the tool [m].
            offset: o [m], from ``far_end_drop``.
            dt: time [s] since the last call.
        """
        if abs(offset) > DEAD_BAND:
            self.height = height - self._share * min(FARTHEST, max(-FARTHEST, offset))
            return self.height
        step = RELAXATION * dt
        self.height += min(step, max(-step, height - self.height))
        # A target taken over from before a restart need not be close to the tool.
        self.height = min(height + FARTHEST, max(height - FARTHEST, self.height))
        return self.height
