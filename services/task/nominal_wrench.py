"""What the robot carries by agreement: half the panel's weight, taken over in the lift and given back on the ground."""

from __future__ import annotations

LIFT_RATE = 10.0  # [N/s] of taking over at most (carry 3)
RELEASE_RATE = 5.0  # [N/s] of fading while the panel is set down (carry 3)
SUPPORTED_SHARE = 0.5  # [1] of half the weight from which the panel counts as lifted


class NominalWrench:
    """Nominal force along base z, at any roll and without a torque; never above zero.

    Args:
        half_weight: m g / 2 [N].
        force: at first [N].
        supported: whether the panel was lifted already.
    """

    def __init__(self, half_weight: float, force: float = 0.0, supported: bool = False) -> None:
        self._half_weight = half_weight
        self.force = min(0.0, max(-half_weight, force))
        self.supported = supported

    def carry(self, measured: float, dt: float) -> float:
        """The force [N] after following the measured one along z [N] down at ``LIFT_RATE`` at most, to -m g / 2.

        Taken over at once it would press the panel down before the person lifts it.
        """
        wanted = max(-self._half_weight, min(self.force, measured))
        self.force = max(wanted, self.force - LIFT_RATE * dt)
        self.supported |= self.force <= -SUPPORTED_SHARE * self._half_weight
        return self.force

    def fade(self, dt: float) -> float:
        """The force [N] after fading at ``RELEASE_RATE``; left on, it would hide that the ground carries the panel."""
        self.force = min(0.0, self.force + RELEASE_RATE * dt)
        return self.force
