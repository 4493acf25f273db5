"""A robot process of one's own: `services/mock` before a soft wall, which pushes back where the tool enters it.

`python -m services.router`, and in a terminal each `examples.robot_at_a_wall`, `services.wrench` and
`services.controller` instead of `tandem up`; then `tandem tare`, and `tandem hold 0.7 -0.3 1 0 0 0 --force-limit 10`:
the tool stays where the wall pushes with 10 N. A bridge to hardware has the same three parts, and drives its motors
where the mock one integrates.
"""

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.loop.entry import end
from shared.loop.process import run
from shared.service import Inputs, Output

WALL = 0.55  # [m] along x of the base
STIFFNESS = 400.0  # [N/m]


class RobotAtAWall(MockRobot):
    """Whatever is commanded passes the gate first, and then moves the tool, into the wall too."""

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """What the wall pushes with is what the sensor feels in this step."""
        self.sensors.wrench[0] = -STIFFNESS * max(0.0, self.motors.position[0] - WALL)
        return super().step(inputs, dt)


if __name__ == "__main__":
    end(run(RobotAtAWall, MockParameters, "mock"))
