"""What the robot carries by agreement: half the panel's weight, taken over in the lift and given back on the ground."""

from __future__ import annotations

LIFT_RATE = 10.0
"""Fastest taking over [N/s] (CARRY 3)."""
RELEASE_RATE = 5.0
"""Fading while the panel is set down [N/s] (CARRY 3)."""
SUPPORTED_SHARE = 0.5
"""Share [1] of half the weight from which the panel counts as lifted."""


class NominalWrench:
    """Nominal force along base z [N], never above zero; whatever the roll, and no torque.

    Args:
        half_weight: m g / 2 [N].
        force: to begin with [N].
        supported: whether the panel was lifted already.
    """

    def __init__(self, half_weight: float, force: float = 0.0, supported: bool = False) -> None:
        self._half_weight = half_weight
        self.force = min(0.0, max(-half_weight, force))
        self.supported = supported

    def carry(self, measured: float, dt: float) -> float:
        """Follow the measured force along z [N] downwards, by at most 10 N/s, until -m g / 2.

        Taken over at once it would press the panel down before the person lifts it.
        """
        wanted = max(-self._half_weight, min(self.force, measured))
        self.force = max(wanted, self.force - LIFT_RATE * dt)
        self.supported |= self.force <= -SUPPORTED_SHARE * self._half_weight
        return self.force

    def fade(self, dt: float) -> float:
        """Give it back: to zero at 5 N/s. Left on, it hides from the controller that the ground carries the panel."""
        self.force = min(0.0, self.force + RELEASE_RATE * dt)
        return self.force
