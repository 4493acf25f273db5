"""The simulated robot behind a bridge, as a process."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from services.ros_robot.parameters import RosRobotParameters
from shared.loop.process import run

if TYPE_CHECKING:
    from services.ros_robot.adapter import Adapter
    from services.ros_robot.process import RosRobotService


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit status."""
    adapters: list[Adapter] = []

    def make(parameters: RosRobotParameters) -> RosRobotService:
        # The physics engine takes its time and announces itself when imported: not before the settings are sound.
        from services.ros_robot.adapter import connect
        from services.ros_robot.process import RosRobotService
        from services.ros_robot.robot import RosRobot
        from services.sim.camera.render_process import RenderProcess
        from shared.robot.profile import Profile

        profile = Profile.load(parameters.profile)
        # Stamps of ROS count from 1970. A robot's clock goes on while its world is held up on a busy machine.
        since_1970 = time.time_ns() - time.monotonic_ns()
        robot = RosRobot(profile, parameters, RenderProcess, clock=lambda: since_1970 + time.monotonic_ns())
        adapters.append(connect(robot, parameters.transport_of(profile.middleware), parameters.address))
        return RosRobotService(parameters, robot, adapters[0])

    try:
        return run(make, RosRobotParameters, "ros_robot", arguments)
    finally:
        for adapter in adapters:
            adapter.close()
