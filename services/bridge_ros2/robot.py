"""The robot under ROS 2, as a bridge meets it."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

from services.bridge_ros2 import codec, commands, mismatches
from services.bridge_ros2.names import End
from services.bridge_ros2.network import Ear, Network
from services.bridge_ros2.parameters import BridgeRos2Parameters
from services.bridge_ros2.sensors import EmergencyStop, Newest
from shared.parameters import Refused
from shared.robot import ros_messages as ros
from shared.robot.far_side import Calibration, Heard, Picture, TrajectoryPoint
from shared.robot.heard_topics import HeardTopics
from shared.robot.profile import Profile
from shared.spatial import Array


class Ros2Robot(HeardTopics):
    """A ``FarSide``; one thread asks and commands it.

    Args:
        profile: of the robot.
        parameters: where it is, and how its topics travel.

    Raises:
        Refused: the profile is of a robot under ROS 1, or the endpoint has not the form of one.
    """

    def __init__(self, profile: Profile, parameters: BridgeRos2Parameters) -> None:
        if profile.middleware != "ros2":
            raise Refused(
                f"robot profile {profile.name} is of {profile.middleware}: services.bridge_{profile.middleware}"
            )
        self._parameters, self._kinds = parameters, profile.heard()
        self._newest = {topic: Newest(self._kinds[topic], read) for topic, read in ros.readers(profile)}
        super().__init__(profile, self._newest)
        stop = profile.emergency_stop
        self._emergency = EmergencyStop(stop.type, stop.pressed) if stop else None
        self._wants_picture = False
        self._commanded = {} if parameters.read_only else profile.commanded()
        self._hashes = {kind: parameters.hash_of(kind) for kind in self._commanded.values()}
        self._unsent: dict[str, tuple[int, str]] = {}
        codec.prepare([*self._kinds.values(), *self._commanded.values()])
        self._network = Network(
            parameters.endpoint, parameters.named(), list(self._ears()), self._commanded, self._on_graph
        )

    def picture(self, wanted: bool) -> tuple[Heard[Picture], Heard[Calibration]] | None:
        camera = self._profile.camera
        if camera is None:
            return None
        image, info = self._newest[camera.image], self._newest[camera.info]
        if self._wants_picture and not wanted:
            image.forget()
            info.forget()
        self._wants_picture = wanted
        if not wanted or image.heard is None or info.heard is None:
            return None
        return image.heard, info.heard

    def emergency(self) -> str:
        return self._emergency.pressed_by() if self._emergency else ""

    def move(self, controller: str, points: Sequence[TrajectoryPoint]) -> None:
        row = self._profile.controllers[controller]
        self._send(row.topic, lambda: commands.trajectory(row.joints, points))

    def drive(self, velocity: Array) -> None:
        base = self._profile.base
        if base:
            self._send(base.topic, lambda: commands.twist(velocity, base.type, self._now()))

    def ready(self) -> str:
        if self._away():
            return self._away()
        stop, ends = self._profile.emergency_stop, self._network.ends
        if stop and self._emergency and not self._emergency.told():
            if not any(end.publishes and end.topic == stop.topic for end in ends):
                return f"nobody tells whether the emergency stop is pressed: nothing publishes {stop.topic}"
            if not stop.latched:
                return f"{stop.topic} has not told yet whether the emergency stop is pressed"
        listened = {end.topic for end in ends if not end.publishes}
        for name in self._profile.arm_controllers():
            row = self._profile.controllers[name]
            if row.topic not in listened:
                return f"nobody listens to {row.topic}: is {row.controller} running?"
        return ""

    def mismatches(self) -> Sequence[str]:
        if self._away():
            return [self._away()]
        ends, stop = self._network.ends, self._profile.emergency_stop
        return [
            *mismatches.heard(ends, self._kinds, stop.topic if stop else ""),
            *mismatches.commanded(ends, self._commanded, self._hashes),
        ]

    def refusals(self) -> Mapping[str, str]:
        told = self._refused()
        if self._profile.emergency_stop and self._emergency:
            told[self._profile.emergency_stop.topic] = self._emergency.refusals
        told |= {topic: f"{count} not sent, the last one: {why}" for topic, (count, why) in self._unsent.items()}
        return {topic: text for topic, text in told.items() if text}

    def close(self) -> None:
        self._network.close()

    def _send(self, topic: str, make: Callable[[], bytes]) -> None:
        try:
            payload = make()
        except commands.Unsent as problem:
            self._unsent[topic] = self._unsent.get(topic, (0, ""))[0] + 1, str(problem)
            return
        self._network.send(topic, payload)

    def _away(self) -> str:
        """Why nothing of the robot is to be seen; empty if something is."""
        if self._network.trouble or self._network.ends:
            return self._network.trouble
        chosen = self._parameters
        how = f"dialect {chosen.dialect}" + (f" and domain {chosen.domain}" if chosen.dialect == "rmw_zenoh" else "")
        return f"no ROS 2 node is to be seen at {chosen.endpoint} in {how}: is the robot up, and are these its own?"

    def _now(self) -> int:
        """The robot's clock [ns], by what it last stamped; 0 before that."""
        heard = self.joints()
        return heard.stamp + time.monotonic_ns() - heard.arrival if heard and heard.stamp else 0

    def _on_graph(self, ends: Collection[End]) -> None:
        stop = self._profile.emergency_stop
        if stop and self._emergency:
            self._emergency.present(sum(end.publishes and end.topic == stop.topic for end in ends))

    def _ears(self) -> Iterator[Ear]:
        camera, stop = self._profile.camera, self._profile.emergency_stop
        for topic, newest in self._newest.items():
            if camera and topic in (camera.image, camera.info):
                yield Ear(topic, newest.kind, newest.offer, wanted=lambda: self._wants_picture)
            else:
                yield Ear(topic, newest.kind, newest.offer)
        if stop and self._emergency:
            yield Ear(stop.topic, stop.type, self._emergency.offer, stop.latched)
