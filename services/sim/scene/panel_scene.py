"""The panel, and what the robot's gripper and a person do to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from services.sim.robot.gripper import Gripper
from services.sim.scene.grip import Grip, about_tool, locate
from services.sim.scene.hands import STIFFNESS, Hands
from services.sim.scene.panel import Panel, PanelSpec
from services.sim.scene.person import Person
from shared.spatial import Array, cross


@dataclass(frozen=True)
class PanelSceneSpec:
    """What the panel, the grip and the person are like.

    Attributes:
        panel: the panel.
        grip_friction: coefficient between the fingers' pads and the panel.
        person_force, person_torque: largest force [N] and torque [Nm] of the person.
        person_stiffness: of the person's arms [N/m].
    """

    panel: PanelSpec
    grip_friction: float
    person_force: float = 60.0
    person_torque: float = 20.0
    person_stiffness: float = STIFFNESS


@dataclass(frozen=True)
class Tool:
    """Pose and motion of the tool, in world.

    Attributes:
        position, rotation: (3,) [m] and (3, 3).
        velocity, spin: (3,) [m/s] and (3,) [rad/s].
    """

    position: Array
    rotation: Array
    velocity: Array
    spin: Array


class PanelScene:
    """A panel on its supports, in the gripper, in the person's hands, or on the ground.

    Attributes:
        panel: the panel.
        person: who holds its other end.
        covered: whether something has been put over the marker on it.

    Args:
        spec: what it is like.
        step: duration [s] of one physics step.
    """

    def __init__(self, spec: PanelSceneSpec, step: float) -> None:
        self._spec = spec
        self._step = step
        self.reset()

    def reset(self) -> None:
        """Back to the start."""
        spec = self._spec
        self.panel = Panel(spec.panel)
        self.person = Person(Hands(spec.person_force, spec.person_torque, spec.person_stiffness))
        self.covered = False
        self._grip = Grip(spec.grip_friction, self.panel.body, self._step)

    def advance(self, tool: Tool, gripper: Gripper) -> tuple[Array, Array] | None:
        """One physics step; force (3,) [N] and torque about the tool's origin (3,) [Nm] on the tool, tool axes."""
        body = self.panel.body
        pads = locate(self.panel, tool.position, tool.rotation)
        twist = np.zeros(6)
        if pads is not None:
            arm = tool.rotation.dot(pads.centre)
            point = tool.position + arm
            moving = body.velocity + cross(body.spin, point - body.position)
            twist[:3] = tool.rotation.T.dot(moving - tool.velocity - cross(tool.spin, arm))
            twist[3:] = tool.rotation.T.dot(body.spin - tool.spin)
        wrench = self._grip.wrench(gripper, pads, twist, self._step)
        push, turn = self.person.step(self.panel, gripper.holding, self._step)
        if wrench is None or pads is None:
            self.panel.step(push, turn, self._step)
            return None
        force, torque = wrench
        added = tool.rotation.dot(force)
        push = push + added
        turn = turn + tool.rotation.dot(torque) + cross(point - body.position, added)
        self.panel.step(push, turn, self._step)
        return -force, -about_tool(force, torque, pads.centre)
