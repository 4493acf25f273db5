"""A robot, a panel and a person in a few lines: the tool goes where the target is, the person leads the far end."""

from __future__ import annotations

import math

import numpy as np

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.states import Observation
from shared.messages import GripperState
from shared.spatial import rotation_from_vector, rotation_vector

MARKER = Pose.from_rpy((0.85, -0.3, 0.825), (0.0, 0.0, -math.pi / 2))
START = Pose.from_rpy((0.40, -0.3, 0.9), (-math.pi / 2, 0.0, 0.0))


class Toy:
    """Everything may be changed at any time.

    Attributes:
        lifted: whether the person carries the other half.
        far_height: of the far end [m], if the person leads it.
        roll_rate: at which the person turns the panel [rad/s].
        stands: height of the tool at which the turned panel stands on the ground [m].
    """

    def __init__(self, parameters: TaskParameters | None = None) -> None:
        self.parameters = parameters or TaskParameters()
        self.tool = START
        self.target: Pose | None = None
        self.opening, self.wanted = 0.04, 0.04
        self.marker: Pose | None = MARKER
        self.lifted = False
        self.far_height: float | None = None
        self.roll_rate = 0.0
        self.stands = self.parameters.standing_height
        self.speed = self.turning = 0.0
        self.session = 1
        self.gripped = self._slipped = False

    @property
    def grasp(self) -> Pose:
        """Where the panel is to be grasped, in base."""
        return MARKER @ Pose.from_rpy(self.parameters.grasp_position, self.parameters.grasp_rpy)

    @property
    def gripper(self) -> GripperState:
        return GripperState(self.opening, 12.0 if self.gripped else 0.0, self.gripped)

    @property
    def wrench(self) -> np.ndarray:
        """External wrench (6,): half the weight once lifted, nothing on the ground."""
        carried = self.gripped and self.lifted and self.tool.position[2] > self.stands + 0.003
        return np.array((0.0, 0.0, -self.parameters.half_weight if carried else 0.0, 0.0, 0.0, 0.0))

    def advance(self, dt: float) -> None:
        """Let time [s] pass."""
        self._grip(dt)
        before, moved = self.tool, self.tool
        if self.target is not None:
            step = self.target.position - moved.position
            step *= min(1.0, 2.0 * dt, 0.25 * dt / max(1e-9, float(np.linalg.norm(step))))
            turn = rotation_vector(self.target.rotation @ moved.rotation.T) * min(1.0, 2.0 * dt)
            moved = Pose(moved.position + step, rotation_from_vector(turn) @ moved.rotation)
        if self.gripped and self.roll_rate:
            moved = moved @ Pose(np.zeros(3), rotation_from_vector((self.roll_rate * dt, 0.0, 0.0)))
        if self.gripped and self.far_height is not None:
            moved = self._led(moved)
        if self.gripped and moved.position[2] < self.stands:
            moved = Pose(np.array((*moved.position[:2], self.stands)), moved.rotation)
        self.tool = moved
        self.speed, self.turning = moved.distance(before) / dt, moved.angle(before) / dt

    def slip(self) -> None:
        """The panel slips out of the fingers, and is not between them again before they have opened."""
        self.gripped, self._slipped = False, True

    def seen(self, **changed: object) -> Observation:
        """What the task would see."""
        values = {
            "tool": self.tool,
            "speed": self.speed,
            "turning": self.turning,
            "session": self.session,
            "wrench": self.wrench,
            "gripper": self.gripper,
            "marker": self.marker,
            "proven": self.marker is not None,
            "guarded": True,
        }
        return Observation(**{**values, **changed})

    def _grip(self, dt: float) -> None:
        step = 0.1 * dt
        self.opening += min(step, max(-step, self.wanted - self.opening))
        width = self.parameters.panel_thickness
        at_panel = self.gripped or (self.tool.near(self.grasp, 0.02, 0.1) and not self._slipped)
        if at_panel and self.wanted < width and self.opening <= width:
            self.opening, self.gripped = width, True
        elif self.wanted >= width and self.opening > width + 1e-4:
            self.gripped = self._slipped = False

    def _led(self, tool: Pose) -> Pose:
        roll, _, yaw = tool.rpy.tolist()
        assert self.far_height is not None
        sine = (tool.position[2] - self.far_height) / self.parameters.panel_length
        return Pose.from_rpy(tool.position, (roll, math.asin(min(0.5, max(-0.5, sine))), yaw))
