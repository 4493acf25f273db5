"""When to let go: the panel was turned and stands on the ground, by the tool's pose and the force alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

from services.task.geometry import QUARTER
from services.task.timers import LeakyTimer, LowPass, Sustained

# All but DIP: carry 5.
PROBE_ROLL, PROBE_PITCH = math.radians(15.0), math.radians(7.0)  # [rad] off a quarter turn, pointing up
PROBE_HEIGHT = 0.06  # [m] above half the panel's width
PROBE_SPEED, PROBE_TURNING = 0.03, 0.03  # [m/s], [rad/s]
PROBE_AFTER = 0.5  # [s] without a break
LEAVE_ROLL, LEAVE_HEIGHT = math.radians(23.0), 0.08  # [rad], [m] from which the probe was a mistake
RELEASE_ROLL, RELEASE_PITCH = math.radians(15.0), math.radians(6.0)  # [rad] off a quarter turn, pointing up
RELEASE_HEIGHT = 0.06  # [m]: 4 cm for the ground, 2 cm for the grasp and the panel's tilt
RELEASE_FORCE = -2.5  # [N] above which the ground carries the panel
RELEASE_AFTER = 1.0  # [s], leaky
FORCE_FILTER = 0.1  # [s] of the low pass
DIP = math.radians(20.0)
"""Largest pitch [rad] that points down. It need not be close: a near end that is up shows in the tool's height. A panel
that has turned between the fingers, because the person's end came down first, leaves the tool like that."""
PRESS_FORCE, PRESS_DEPTH = -1.0, 0.01  # [N], [m] below the tool: how the probe sets the panel down


@dataclass(frozen=True)
class Stance:
    """How the tool stands.

    Attributes:
        roll: about its own x axis since the grasp [rad].
        pitch: [rad]; positive points the panel's far end down.
        height: above where it is with the turned panel on the ground [m].
        speed: [m/s].
        turning: [rad/s].
        force: external, along base z [N].
    """

    roll: float
    pitch: float
    height: float
    speed: float
    turning: float
    force: float

    @property
    def off_quarter(self) -> float:
        """How far the roll is from 90 degrees to either side [rad]."""
        return abs(abs(self.roll) - QUARTER)


class ReleaseJudge:
    """Two stages: from the pose that the panel is about to stand, then from pose and force that the ground carries it.

    Pose alone fired early in 45 of 46 carries of the quick model.
    """

    def __init__(self) -> None:
        self._about_to_stand = Sustained(PROBE_AFTER)
        self._carried = LeakyTimer(RELEASE_AFTER)
        self._force = LowPass(FORCE_FILTER)

    @property
    def force(self) -> float:
        """External force along z [N], low-passed."""
        return self._force.value or 0.0

    def may_probe(self, stance: Stance, dt: float) -> bool:
        """Stage (a): whether the panel was turned, low, level and slow for ``PROBE_AFTER``."""
        self._force.update(stance.force, dt)
        self._carried.reset()
        return self._about_to_stand.update(not why_no_probe(stance), dt)

    def may_release(self, stance: Stance, dt: float, pose_matters: bool = True) -> bool:
        """Stage (b): whether the panel was turned, low, level and not carried for ``RELEASE_AFTER``.

        Args:
            stance: now.
            dt: time [s] since the last call.
            pose_matters: false if a person said that the panel is to be let go where it is.
        """
        force = self._force.update(stance.force, dt)
        self._about_to_stand.reset()
        met = not why_no_release(stance, force) if pose_matters else force > RELEASE_FORCE
        return self._carried.update(met, dt)

    def has_to_leave(self, stance: Stance) -> bool:
        """Whether the probe was a mistake: turned back, or lifted again."""
        return stance.off_quarter > LEAVE_ROLL or stance.height > LEAVE_HEIGHT

    def press(self) -> float:
        """How far below the tool the target is to be [m] while the probe sets the panel down."""
        return PRESS_DEPTH if self.force < PRESS_FORCE else 0.0


def why_no_probe(stance: Stance) -> list[str]:
    """What is still missing for stage (a), in words."""
    return _missing(
        (stance.off_quarter <= PROBE_ROLL, f"turned by {_deg(abs(stance.roll))} of 90 degrees"),
        (stance.height < PROBE_HEIGHT, f"{stance.height * 100:.0f} cm above the ground"),
        (-PROBE_PITCH < stance.pitch < DIP, f"tilted by {_deg(abs(stance.pitch))} degrees"),
        (stance.speed < PROBE_SPEED and stance.turning < PROBE_TURNING, "still moving"),
    )


def why_no_release(stance: Stance, force: float) -> list[str]:
    """What is still missing for stage (b), in words; the force comes last."""
    return _missing(
        (stance.off_quarter <= RELEASE_ROLL, f"turned by {_deg(abs(stance.roll))} of 90 degrees"),
        (stance.height < RELEASE_HEIGHT, f"{stance.height * 100:.0f} cm above the ground"),
        (-RELEASE_PITCH < stance.pitch < DIP, f"tilted by {_deg(abs(stance.pitch))} degrees"),
        (force > RELEASE_FORCE, f"the robot still carries {-force:.1f} N"),
    )


def _missing(*conditions: tuple[bool, str]) -> list[str]:
    return [text for met, text in conditions if not met]


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.0f}"
