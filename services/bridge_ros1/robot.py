"""The robot under ROS 1, as a bridge meets it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

from services.bridge_ros1 import mismatches
from services.bridge_ros1.commands import Outlet, Unsent, trajectory, twist
from services.bridge_ros1.debian import find_rospy
from services.bridge_ros1.master import Graph, Master
from services.bridge_ros1.names import heard
from services.bridge_ros1.node import EVERY, Ear, Node
from services.bridge_ros1.sensors import EmergencyStop, Newest
from services.bridge_ros1.switching import Switching
from shared.robot import ros_messages as ros
from shared.robot.far_side import Calibration, Heard, Picture, TrajectoryPoint
from shared.robot.heard_topics import HeardTopics
from shared.robot.profile import Profile
from shared.spatial import Array

SETTLED = 1.0
"""Time [s] for which a mismatch lasts before it is told."""
NODE = "tandem"
"""Name of the node, in front of what makes it unique."""


class Ros1Robot(HeardTopics):
    """A ``FarSide``.

    Args:
        profile: of the robot.
        read_only: nothing is published, and no controller switched.
        master: address of the master; ROS_MASTER_URI if empty.
        ports: first of the two at which nodes of the robot reach this one; 0 for any free ones.

    Raises:
        Refused: rospy is missing, or the address is none.
    """

    def __init__(self, profile: Profile, read_only: bool = False, master: str = "", ports: int = 0) -> None:
        find_rospy()
        self._newest = {topic: Newest(read) for topic, read in ros.readers(profile)}
        super().__init__(profile, self._newest)
        self._emergency = EmergencyStop(profile.emergency_stop.pressed if profile.emergency_stop else True)
        self._picture_wanted = False
        self._ears = self._all_ears()
        self._outlets = {} if read_only else {topic: Outlet(topic, kind) for topic, kind in profile.commanded().items()}
        self._switching = Switching(profile, read_only)
        self._looks: Mapping[str, int] = {}
        self._master = Master(master or os.environ.get("ROS_MASTER_URI", "http://localhost:11311"), f"/{NODE}")
        self._node = Node(
            self._master, NODE, self._ears, list(self._outlets.values()), self._look, self._switching.back, ports
        )

    def picture(self, wanted: bool) -> tuple[Heard[Picture], Heard[Calibration]] | None:
        camera = self._profile.camera
        if camera is None:
            return None
        if wanted != self._picture_wanted:
            self._picture_wanted = wanted
            self._node.wake()
        picture, calibration = self._newest[camera.image].heard, self._newest[camera.info].heard
        return (picture, calibration) if picture and calibration else None

    def emergency(self) -> str:
        return self._emergency.pressed_by()

    def move(self, controller: str, points: Sequence[TrajectoryPoint]) -> None:
        row = self._profile.controllers[controller]
        self._send(row.topic, lambda: trajectory(row.joints, points))

    def drive(self, velocity: Array) -> None:
        base = self._profile.base
        if base:
            self._send(base.topic, lambda: twist(velocity, base.type))

    def ready(self) -> str:
        stop = self._profile.emergency_stop
        if self._node.graph is None:
            return self._node.trouble
        if stop and not self._emergency.told() and not self._node.graph.publishers.get(stop.topic):
            return f"nobody tells whether the emergency stop is pressed: nothing publishes {stop.topic}"
        return self._switching.trouble

    def mismatches(self) -> Sequence[str]:
        if trouble := self._node.trouble:
            return [trouble]
        return [line for line, looks in self._looks.items() if looks * EVERY > SETTLED]

    def refusals(self) -> Mapping[str, str]:
        told = self._refused()
        told |= {topic: outlet.failures for topic, outlet in self._outlets.items()}
        return {topic: text for topic, text in told.items() if text}

    def close(self) -> None:
        self._node.close()

    def _send(self, topic: str, make: Any) -> None:
        outlet = self._outlets.get(topic)
        if outlet is None:
            return
        try:
            outlet.send(make())
        except Unsent as problem:
            outlet.not_sent(str(problem))

    def _look(self, graph: Graph) -> None:
        """What the robot's nodes say and hear, in the node's thread."""
        if self._profile.emergency_stop:
            self._emergency.present(graph.publishers.get(self._profile.emergency_stop.topic, ()))
        self._switching.look(graph.services)
        found = (
            *mismatches.heard(graph, [ear for ear in self._ears if ear.wanted()]),
            *mismatches.commanded(graph, list(self._outlets.values()), self._master.caller),
        )
        # Connections take their time: what is told has been so for a while.
        self._looks = {line: self._looks.get(line, 0) + 1 for line in found}

    def _all_ears(self) -> list[Ear]:
        camera, stop, kinds = self._profile.camera, self._profile.emergency_stop, heard(self._profile)
        ears = [Ear(topic, kinds[topic], newest) for topic, newest in self._newest.items()]
        base = self._profile.base
        lasting = {self._profile.joints.topic, self._profile.wrench.topic, *([base.odometry] if base else [])}
        for ear in ears:
            if camera and ear.topic in (camera.image, camera.info):
                ear.wanted, ear.forget = lambda: self._picture_wanted, self._newest[ear.topic].forget
                ear.large = ear.topic == camera.image
            elif ear.topic in lasting:
                ear.silence = self._newest[ear.topic].silence
        return [*ears, Ear(stop.topic, stop.type, self._emergency, shared=True)] if stop else ears
