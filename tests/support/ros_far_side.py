"""The simulated ROS robot and a bridge without any middleware between them, under simulated time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from services.ros_robot.messages import Flag, Point, Publication, Trajectory, Twist
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.process import RosRobotService
from services.ros_robot.robot import RosRobot
from services.sim.camera.head_camera import DirectRendering, Rendering
from services.sim.camera.view import Scenery
from shared.loop.stack import Stack
from shared.messages import RobotStatus, Stop
from shared.robot.bridge.bridge import Bridge
from shared.robot.bridge.parameters import BridgeParameters
from shared.robot.far_side import Calibration, Heard, Joints, Odometry, Picture, TrajectoryPoint, Wrench
from shared.robot.profile import Profile
from shared.topics import STATE_ROBOT, STOP

WALL = 1_700_000_000 * 10**9
"""[ns] of the wall clock at the start."""


class DirectSide:
    """The far side of a bridge, which is the robot itself, and that robot's adapter.

    Attributes:
        moved: trajectories and velocities that were sent.
    """

    def __init__(self, profile: Profile, robot: RosRobot, stack: Stack) -> None:
        self._profile, self._robot, self._stack = profile, robot, stack
        self._heard: dict[str, Heard[Any]] = {}
        self._pressed_by: dict[str, bool] = {}
        self._wanted = False
        self.moved = 0

    def publish(self, publications: Sequence[Publication]) -> None:
        for publication in publications:
            self._hear(publication)

    def watched(self) -> bool:
        return self._wanted

    def notes(self) -> str:
        return ""

    def _hear(self, publication: Publication) -> None:
        if isinstance(publication.content, Flag):
            row = self._profile.emergency_stop
            assert row is not None
            self._pressed_by[publication.node] = publication.content.value == row.pressed
            return
        number = self._heard[publication.topic].number + 1 if publication.topic in self._heard else 1
        arrival = self._stack.scheduler.clock.now_ns()
        heard = Heard(publication.content, number, arrival, publication.stamp, publication.node)
        self._heard[publication.topic] = heard

    def joints(self) -> Heard[Joints] | None:
        return self._heard.get(self._profile.joints.topic)

    def wrench(self) -> Heard[Wrench] | None:
        return self._heard.get(self._profile.wrench.topic)

    def odometry(self) -> Heard[Odometry] | None:
        return self._heard.get(self._profile.base.odometry) if self._profile.base else None

    def picture(self, wanted: bool) -> tuple[Heard[Picture], Heard[Calibration]] | None:
        self._wanted = wanted
        camera = self._profile.camera
        assert camera is not None
        if camera.image not in self._heard or camera.info not in self._heard:
            return None
        return self._heard[camera.image], self._heard[camera.info]

    def emergency(self) -> str:
        return ", ".join(name for name, pressed in self._pressed_by.items() if pressed)

    def pressed(self) -> Heard[bool] | None:
        return None

    def move(self, controller: str, points: Sequence[TrajectoryPoint]) -> None:
        self.moved += 1
        row = self._profile.controllers[controller]
        knots = tuple(Point(point.after, point.position, point.velocity) for point in points)
        self._robot.command(row.topic, Trajectory(row.joints, knots))

    def drive(self, velocity: np.ndarray) -> None:
        assert self._profile.base is not None
        self.moved += 1
        self._robot.command(self._profile.base.topic, Twist(velocity))

    def ready(self) -> str:
        running = {row.name for row in self._robot.listed() if row.state in ("running", "active")}
        missing = [row.controller for row in self._profile.controllers.values() if row.controller not in running]
        return f"{', '.join(missing)} does not run" if missing else ""

    def mismatches(self) -> Sequence[str]:
        return ()

    def refusals(self) -> Mapping[str, str]:
        return {topic: f"{count} refused, the last: {why}" for topic, (count, why) in self._robot.refusals().items()}

    def close(self) -> None:
        return None


class RosRig:
    """A bridge to the simulated ROS robot, on a stack.

    Args:
        profile: of the robot.
        robot: its parameters.
        bridge: the bridge's.
        stack: one of their own if left out.
        rendering: of the robot's camera.
    """

    def __init__(
        self,
        profile: str = "tiago-ros1",
        robot: Mapping[str, Any] = {},
        bridge: Mapping[str, Any] = {},
        stack: Stack | None = None,
        rendering: Callable[[Scenery], Rendering] = DirectRendering,
    ) -> None:
        self.stack = stack = stack or Stack()
        clock = stack.scheduler.clock
        chosen = RosRobotParameters.of({"profile": profile, "scene": "load"} | robot)
        self.robot = RosRobot(Profile.load(profile), chosen, rendering, lambda: WALL + clock.now_ns())

        def make(known: Profile, _: BridgeParameters) -> DirectSide:
            self.far = DirectSide(known, self.robot, stack)
            return self.far

        parameters = BridgeParameters.of({"profile": profile, "require_enable": False} | bridge)
        self.bridge = Bridge(parameters, make, clock, lambda: WALL + clock.now_ns())
        self.runners = {
            "ros_robot": stack.add(RosRobotService(chosen, self.robot, self.far)),
            "robot": stack.add(self.bridge),
        }
        self.told: list[RobotStatus] = []
        stack.client.watch(STATE_ROBOT, lambda received: self.told.append(received.message))

    @property
    def status(self) -> RobotStatus:
        return self.told[-1]

    def release(self) -> None:
        """`tandem resume`."""
        self.stack.run(0.5)
        self.stack.client.publish(STOP, Stop(False, ""))
        self.stack.run(0.1)
