"""The simulated world: the robot and everything that acts on its tool."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from services.sim.robot.arm import Arm, JointSetPoint
from services.sim.robot.base import MobileBase, Vector
from services.sim.robot.gripper import Gripper
from services.sim.robot.head import Head
from services.sim.scene.bag import Bag
from services.sim.scene.panel_scene import PanelScene, Tool
from shared.sim_messages import BagState, HandState, PanelState, SimWorld
from shared.spatial import Array, quaternion, rotation_from_vector


@dataclass
class _Push:
    """A force [N] and torque [Nm] at the tool, base axes, for so much longer [s]."""

    force: Array
    torque: Array
    left: float


class World:
    """Robot, bag, pushes and, if they are there, the panel and the person.

    Attributes:
        time: simulated time [s] since the process started.
        start: positions of the joints at the start [m, rad], by name; those not named are at zero.
        contact_force, contact_torque: force (3) [N] that bag, panel and pushes exert on the tool, and the torque
            (3) [Nm] of panel and pushes about its origin, in world.

    Args:
        step: duration [s] of one physics step.
        start: see above.
        scene: the panel and the person, if they are there.
        slope: rise of the floor [rad] along x and y of world, which arm and bag feel.
    """

    def __init__(
        self,
        step: float,
        start: Mapping[str, float],
        scene: PanelScene | None = None,
        slope: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.start = start
        self.arm = Arm(step, self.start)
        self.head = Head(self.start)
        self._slope = slope
        self.base = MobileBase(slope)
        self.bag = Bag(self.base.down_in_world)
        self.gripper = Gripper()
        self.panel_scene = scene
        self.time = 0.0
        self.contact_force = [0.0, 0.0, 0.0]
        self.contact_torque = [0.0, 0.0, 0.0]
        self._step = step
        self._pushes: list[_Push] = []

    def reset(self) -> None:
        """Back to the start: base and arm at home, no bag, no push. Time goes on."""
        self.arm.reset()
        self.head.reset()
        if self.panel_scene is not None:
            self.panel_scene.reset()
        self.gripper.reset()
        self.base = MobileBase(self._slope)
        self.bag = Bag(self.base.down_in_world)
        self._pushes = []
        self.contact_force = [0.0, 0.0, 0.0]
        self.contact_torque = [0.0, 0.0, 0.0]

    def load(self, mass: float) -> None:
        """Hang a bag of that total mass [kg] from the tool, or make the one there so heavy; 0 takes it off."""
        self.bag.load(mass, self.base.point(self._tool()))

    def push(self, force: Array, torque: Array, duration: float) -> None:
        """Push the tool with a force (3,) [N] and a torque (3,) [Nm], base axes, for a duration [s]."""
        self._pushes.append(_Push(force, torque, duration))

    def advance(self, arm: Array | JointSetPoint, base_velocity: Array, stopped: bool = False) -> None:
        """One physics step.

        Args:
            arm: the twist (6,) that the arm is told to move its tool with, relative to base, or its joints' set-points.
            base_velocity: of the base: vx, vy [m/s], wz [rad/s] (3,).
            stopped: whether fingers and head have to stay where they are.
        """
        if not stopped:
            self.gripper.advance(self._step)
            self.head.advance(self._step)
        vx, vy, wz = base_velocity.tolist()
        self.base.advance((vx, vy, wz), self._step)
        self.arm.feel(self.base)
        force, torque = self._pull(), None
        if self._pushes:
            total = np.zeros(3)
            for push in self._pushes:
                force = [a + b for a, b in zip(force, push.force.tolist(), strict=True)]
                total += push.torque
                push.left -= self._step
            self._pushes = [push for push in self._pushes if push.left > 0.5 * self._step]
            torque = total.tolist()
        if self.panel_scene is not None:
            force, torque = self._carried(self.panel_scene, force, torque)
        self.arm.advance(arm, force, torque)
        x, y, z = force
        self.contact_force = list(self.base.turned((x, y, z)))
        tx, ty, tz = torque or (0.0, 0.0, 0.0)
        self.contact_torque = list(self.base.turned((tx, ty, tz)))
        self.time += self._step

    def camera(self) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of the head camera's optical frame in base."""
        return self.head.camera(self.arm.physics.positions[0])

    def told(self, marker_visible: bool) -> SimWorld:
        """What is true, as a message; whether the marker is in the picture the camera knows."""
        bag = BagState(self.bag.mass, self.bag.height) if self.bag.present else None
        panel = hand = None
        if (scene := self.panel_scene) is not None:
            body = scene.panel.body
            panel = PanelState(body.position, quaternion(body.rotation), 2.0 * scene.panel.half)
            if scene.person.asked:
                hands = scene.person.hands
                wanted, turned = hands.wish(scene.panel)
                hand = HandState(hands.place, hands.force, hands.torque, scene.person.doing, wanted, quaternion(turned))
        return SimWorld(self.time, panel, bag, hand, np.array(self.contact_force), marker_visible)

    def _tool(self) -> Vector:
        """Position [m] of the tool in base."""
        x, y, z = self.arm.tool_position.tolist()
        return x, y, z

    def _carried(
        self, scene: PanelScene, force: list[float], torque: list[float] | None
    ) -> tuple[list[float], list[float] | None]:
        """Force [N] and torque [Nm] on the tool, base axes, with what the panel adds to them in this step."""
        position, rotation = self.arm.kinematics.tool()
        x, y, z = position.tolist()
        vx, vy, vz, *spin = self.arm.tool_twist.tolist()
        heading = rotation_from_vector((0.0, 0.0, self.base.yaw))
        turning = heading.dot(spin)
        turning[2] += self.base.velocity[2]
        tool = Tool(
            np.array(self.base.point((x, y, z))),
            heading.dot(rotation),
            np.array(self.base.velocity_of((x, y, z), (vx, vy, vz))),
            turning,
        )
        wrench = scene.advance(tool, self.gripper)
        if wrench is None:
            return force, torque
        added = rotation.dot(wrench[0])
        turned = rotation.dot(wrench[1]) + (0.0 if torque is None else np.array(torque))
        return (added + force).tolist(), turned.tolist()

    def _pull(self) -> list[float]:
        """Force (3) [N] of the bag on the tool in this step, base axes."""
        if not self.bag.present:
            return [0.0, 0.0, 0.0]
        tool = self._tool()
        vx, vy, vz, *_ = self.arm.tool_twist.tolist()
        velocity = self.base.velocity_of(tool, (vx, vy, vz))
        return list(self.base.turned_back(self.bag.step(self.base.point(tool), velocity, self._step)))
