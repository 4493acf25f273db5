"""What the gripper is told: to close and stay closed, to open, or to stay where it is."""

from __future__ import annotations

from services.task.parameters import TaskParameters
from services.task.timers import Sustained
from shared.messages import GripperCommand, GripperState

OPEN_AFTER = 0.3  # [s] for which the gripper has to say that it is open


class Fingers:
    """An opening goes on until the gripper is open or `stop` breaks it off.

    Broken off, the fingers stay where they are, and close on what they still hold, as soon as it is known where that
    is; and they stay until they are told to open or to close again.

    Attributes:
        hold: whether they hold something, as far as is known.
        opening: whether they are being opened.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self._settings = parameters
        self._opened = Sustained(OPEN_AFTER)
        self._stay: GripperCommand | None = None
        self._broken_off = False
        self.hold = False
        self.opening = False

    @property
    def command(self) -> GripperCommand | None:
        """What the gripper has to be told at present; None if it may do what it does."""
        if self.opening:
            return GripperCommand(self._settings.gripper_open, self._settings.gripper_effort)
        if self.hold:
            return GripperCommand(0.0, self._settings.gripper_effort)
        return self._stay

    @property
    def certain(self) -> bool:
        """Whether `hold` is known: not while an opening was broken off out of sight."""
        return not self._broken_off

    def open(self) -> None:
        """Open from now on: nothing is held any more."""
        self._forget()
        self.opening = True
        self._opened.reset()

    def close(self, hold: bool = True) -> None:
        """Hold something from now on, and close on it; or nothing, and leave the fingers where they are."""
        self._forget()
        self.hold = hold

    def stop(self, gripper: GripperState | None) -> None:
        """Break off an opening; without one nothing happens."""
        if self.opening:
            self.opening, self._broken_off = False, True
        self.look(gripper)

    def look(self, gripper: GripperState | None) -> None:
        """Take in what is known of the gripper now."""
        if self._broken_off and gripper is not None:
            self._broken_off, self.hold = False, gripper.holding
            self._stay = GripperCommand(max(0.0, gripper.opening), self._settings.gripper_effort)

    def opened(self, gripper: GripperState | None, dt: float) -> bool:
        """Whether an opening has come to its end: the gripper says that it is open and holds nothing, for a while."""
        wide = self._settings.panel_thickness + self._settings.grasp_width / 2
        is_open = gripper is not None and gripper.opening >= wide and not gripper.holding
        if self._opened.update(is_open, dt):
            self.opening = False
        return not self.opening

    def _forget(self) -> None:
        self.hold = self.opening = self._broken_off = False
        self._stay = None
