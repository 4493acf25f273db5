"""What the robot publishes of itself, in the names, frames and signs of its profile, planted mistakes included."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from services.ros_robot.messages import Content, Publication
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.pictures import calibration, decoded
from services.sim.camera.head_camera import HeadCamera, Rendering
from services.sim.camera.view import Scenery
from services.sim.pace import Ticks
from services.sim.robot.sensor_line import SensorLine
from services.sim.robot.sensors import ForceTorqueSensor, JointSensors
from services.sim.scene.world import World
from shared.messages import CameraImage
from shared.robot.far_side import Joints, Odometry, Wrench
from shared.robot.profile import Profile
from shared.robot.tiago import FINGERS
from shared.spatial import quaternion_from_rpy, rotation_matrix

EXTRA_JOINTS = (
    *(f"caster_{end}_{side}_{at}_joint" for end in ("front", "back") for side in ("left", "right") for at in (1, 2)),
    "suspension_left_joint",
    "suspension_right_joint",
)
"""What ROS 2 reports besides, with numbers that mean nothing."""
HOUR = 3600 * 10**9  # [ns] by which a planted clock is ahead
LEFT_OVER, LEFT_OVER_RATE = "joint_state_publisher", 10.0
"""The second node that publishes joint states, and its rate [Hz]."""
TOOL_LINK = "arm_right_tool_link"
ODOMETRY_FRAME = "odom"
JOINT_STATE = "sensor_msgs/JointState"
_IN_TOOL_LINK = rotation_matrix(quaternion_from_rpy(0.5 * math.pi, 0.0, 0.5 * math.pi))
_TURNED = rotation_matrix(quaternion_from_rpy(0.0, 0.0, math.radians(45.0)))


@dataclass(frozen=True)
class _OnItsWay:
    """A publication with what a broken line does to it."""

    publication: Publication
    late: float = 0.0
    payload: bytes | None = None


class Sensors:
    """Encoders, the wrist's sensor, odometry and camera, each at its rate.

    Attributes:
        lines: of the sensors that ``sim/command`` breaks, by the names that it gives them. Garbage is numbers that are
            none: ROS carries nothing else under a type.
        camera: None in a scene without a panel.

    Args:
        profile: names topics, frames and rates.
        parameters: the sensors' errors and the planted mistakes.
        world: that they measure.
        rendering: makes what renders the camera's pictures.
        clock: [ns] the robot's clock.
    """

    def __init__(
        self,
        profile: Profile,
        parameters: RosRobotParameters,
        world: World,
        rendering: Callable[[Scenery], Rendering],
        clock: Callable[[], int],
    ) -> None:
        self._profile, self._world, self._clock = profile, world, clock
        self._camera_rate = parameters.camera_rate
        self._mistakes = frozenset(parameters.mistakes)
        self.lines = {"ft": SensorLine(), "joints": SensorLine(), "camera": SensorLine()}
        noise = parameters.ft_noise, parameters.ft_bias, parameters.ft_drift, parameters.seed
        self._force_torque = ForceTorqueSensor(*noise)
        self._encoders = JointSensors(world.arm, world.head, world.gripper, world.start, self.lines["joints"])
        self._turn = 0
        self.camera: HeadCamera | None = None
        if world.panel_scene is not None:
            line = self.lines["camera"]
            self.camera = HeadCamera(world, world.panel_scene, parameters.scenery(), rendering, line)

    def stamp(self, late: float = 0.0) -> int:
        """[ns] of the robot's clock, so many seconds ago."""
        return self._clock() - round(late * 1e9) + (HOUR if "clock" in self._mistakes else 0)

    def read(self, ticks: Ticks, watched: bool) -> list[Publication]:
        """The publications that are due in this tick; the camera's only while somebody watches."""
        profile, tick = self._profile, 1.0 / ticks.rate
        joints = [self._joint_states()] if ticks.due(profile.joints.rate) else []
        wrench = [self._wrench()] if ticks.due(profile.wrench.rate) else []
        told = _sent(self.lines["joints"], joints, tick) + _sent(self.lines["ft"], wrench, tick)
        if "two_publishers" in self._mistakes and ticks.due(LEFT_OVER_RATE):
            names = self._joint_states().content.names  # type: ignore[union-attr]
            nothing = np.zeros(len(names))
            state = Joints(names, nothing, nothing, nothing)
            told.append(Publication(profile.joints.topic, JOINT_STATE, state, self.stamp(), node=LEFT_OVER))
        if profile.base is not None and ticks.due(profile.base.rate):
            told.append(self._odometry(profile.base.odometry))
        if self.camera is not None and profile.camera is not None:
            expose = watched and ticks.due(min(profile.camera.rate, self._camera_rate))
            for shot in self.camera.shots(expose, self._world.time, tick, 1.0):
                told += self._pictures(shot.message, shot.late)  # type: ignore[arg-type]
        return told

    def _joint_states(self) -> Publication:
        state, _ = self._encoders.measure()
        effort = state.effort.copy()
        effort[[state.name.index(finger) for finger in FINGERS]] = self._world.gripper.effort
        extra = EXTRA_JOINTS if self._profile.middleware == "ros2" else ()
        dummies = np.zeros(len(extra))
        names = (*state.name, *extra)
        values = [np.concatenate((own, dummies)) for own in (state.position, state.velocity, effort)]
        if "joint_order" in self._mistakes:
            self._turn = 1 - self._turn
            if self._turn:
                names, values = names[::-1], [own[::-1] for own in values]
        return Publication(self._profile.joints.topic, JOINT_STATE, Joints(names, *values), self.stamp())

    def _wrench(self) -> Publication:
        row, line = self._profile.wrench, self.lines["ft"]
        true = self._world.arm.physics.wrist_wrench
        reading, _ = line.stick(lambda: self._force_torque.read(true(), self._world.time))
        axes, frame = row.axes.T, self._profile.frames.sensor
        if "sign" in self._mistakes:
            axes = -axes
        if "turned" in self._mistakes:
            axes = axes @ _TURNED
        if "tool_frame" in self._mistakes:
            axes, frame = axes @ _IN_TOOL_LINK, TOOL_LINK
        force, torque = line.shift(reading).reshape(2, 3) @ axes.T
        wrench = Wrench(force, torque, frame)
        return Publication(row.topic, "geometry_msgs/WrenchStamped", wrench, self.stamp(), frame)

    def _odometry(self, topic: str) -> Publication:
        base = self._world.base
        odometry = Odometry(np.array((base.x, base.y)), base.yaw, np.array(base.velocity))
        return Publication(topic, "nav_msgs/Odometry", odometry, self.stamp(), ODOMETRY_FRAME)

    def _pictures(self, image: CameraImage, late: float) -> list[Publication]:
        camera = self._profile.camera
        assert camera is not None
        wrong = "bgr8" in self._mistakes
        contents: tuple[tuple[str, str, Content], ...] = (
            (camera.image, "sensor_msgs/Image", decoded(image, "bgr8" if wrong else camera.encoding)),
            (camera.info, "sensor_msgs/CameraInfo", calibration(image, wrong)),
        )
        frame, stamp = self._profile.frames.camera, self.stamp(late)
        return [Publication(topic, kind, content, stamp, frame) for topic, kind, content in contents]


def _sent(line: SensorLine, publications: list[Publication], tick: float) -> list[Publication]:
    arrived = line.send([_OnItsWay(publication) for publication in publications], tick)
    return [one.publication if one.payload is None else _spoilt(one.publication) for one in arrived]


def _spoilt(publication: Publication) -> Publication:
    """The same with numbers that are none."""
    content = publication.content
    if isinstance(content, Wrench):
        return replace(publication, content=replace(content, force=np.full(3, math.nan)))
    assert isinstance(content, Joints)
    return replace(publication, content=replace(content, position=np.full(len(content.names), math.nan)))
