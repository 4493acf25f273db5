"""The parallel gripper's two fingers and their drives."""

from __future__ import annotations

from shared.robot.tiago import FINGER_EFFORT, FINGER_SPEED

EASE_ABOVE = 0.3  # [N] beyond the effort on both fingers at which the drives ease off
EASE_SPEED = 0.002  # [m/s] at which the drives ease off


class Gripper:
    """Each finger closes until it meets resistance of the wanted effort; its gear then holds it there.

    A load across the fingers presses on one of them more than the effort, and on the other one less until it has
    followed. When the load is gone both press too much; then the drives ease off.

    Attributes:
        left, right: distance [m] of each finger's pad from the middle, along the tool's y axis and against it.
        pressed: force [N] of whatever is gripped on each finger's pad, left and right; set by who knows what that is.
        holding: whether both fingers press on one thing.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Back to the start: closed on nothing."""
        self.left = self.right = 0.0
        self.pressed = (0.0, 0.0)
        self.holding = False
        self._target = (0.0, 0.0)
        self._effort = FINGER_EFFORT

    @property
    def opening(self) -> float:
        """Distance [m] between the fingers."""
        return self.left + self.right

    @property
    def effort(self) -> float:
        """Force [N] with which they close on what is between them."""
        return min(*self.pressed, self._effort)

    def command(self, opening: float, effort: float) -> None:
        """Take over a wanted opening [m] and the effort [N] of each finger for it."""
        self._target = (0.5 * opening, 0.5 * opening)
        self._effort = effort

    def stay(self) -> None:
        """Want the fingers where they are. On what they hold, or were closing on, they close: nothing is let go of."""
        closing = self._target[0] < self.left or self._target[1] < self.right
        if closing and any(self.pressed):
            return
        if self.holding:
            self._target, self._effort = (0.0, 0.0), max(self._effort, min(*self.pressed, FINGER_EFFORT))
        else:
            self._target = (self.left, self.right)

    def advance(self, dt: float) -> None:
        """Let the drives move the fingers for ``dt`` [s]."""
        left, right = self.pressed
        if left == right == 0.0 and (self.left, self.right) == self._target:
            return
        eased = EASE_SPEED * dt if min(left, right) > self._effort + EASE_ABOVE else 0.0
        self.left = self._moved(self.left, self._target[0], left, dt) + eased
        self.right = self._moved(self.right, self._target[1], right, dt) + eased

    def _moved(self, place: float, target: float, pressed: float, dt: float) -> float:
        if place > target and pressed >= self._effort:
            return place
        return place + min(max(target - place, -FINGER_SPEED * dt), FINGER_SPEED * dt)
