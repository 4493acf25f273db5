"""The simulated robot as a service: ROS is all that commands it; on the project's own bus it only has a world.

``sim/world`` and ``sim/command`` are this process' and not the bridge's: people hang a bag or play the second carrier
as with the plain simulation, and the bridge in between is none the wiser.
"""

from __future__ import annotations

from services.ros_robot.adapter import Adapter
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.robot import RosRobot
from services.sim.pace import Pace
from shared import topics
from shared.faults import Fault
from shared.requests import Nothing
from shared.schema.records import Record
from shared.service import Inputs, Output, Reply, Service, Wiring
from shared.topics import Query


class RosRobotService(Service[RosRobotParameters]):
    """Ticks the robot, hands what it publishes to the adapter, and tells of its world.

    Args:
        parameters: in force.
        robot: made of them.
        adapter: that carries its topics.
    """

    def __init__(self, parameters: RosRobotParameters, robot: RosRobot, adapter: Adapter) -> None:
        super().__init__(parameters)
        self._robot, self._adapter = robot, adapter
        self._pace = Pace("control_rate or physics_rate")
        self._until_world = 0.0
        self.wiring = Wiring(
            name="ros_robot",
            driver=1.0 / robot.rate,
            queries=(topics.SIM_COMMAND,),
            # A late tick is no reason to stop the world.
            overrun_share=1.0,
        )

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Simulate one tick; ``dt`` [s] of real time have passed since the last one."""
        tick = 1.0 / self._robot.rate
        self._pace.add(dt, tick)
        self._adapter.publish(self._robot.tick(self._adapter.watched()))
        self._until_world -= tick
        if self._until_world > 0.0:
            return []
        self._until_world += 1.0 / topics.SIM_WORLD.rate
        return [Output(topics.SIM_WORLD, self._robot.world())]

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """The world stands still with the process."""
        return [Output(topics.SIM_WORLD, self._robot.world(), valid=False)]

    def query(self, query: Query, request: Record, reply: Reply) -> None:
        """Answer ``sim/command``."""
        self._robot.carry_out(request)
        reply(Nothing())

    def notes(self) -> str:
        """Planted mistakes, commands without effect, whether it keeps up, and what the adapter has to say."""
        planted = self.parameters.mistakes
        refused = [
            f"{topic}: {count} commands without effect, the last: {why}"
            for topic, (count, why) in self._robot.refusals().items()
        ]
        parts = (planted and f"planted: {', '.join(planted)}", *refused, self._pace.complaint, self._adapter.notes())
        return "; ".join(part for part in parts if part)
