"""The parameters of the simulated robot behind a bridge."""

from __future__ import annotations

from typing import Literal, get_args

from services.sim.parameters import WorldParameters
from shared.parameters import Refused, option, parameter

Mistake = Literal[
    "sign",
    "turned",
    "joint_order",
    "tool_frame",
    "emergency",
    "not_switchable",
    "bgr8",
    "two_publishers",
    "clock",
    "mux_locked",
]
Transport = Literal["", "ros1", "rmw_zenoh", "dds", "none"]
MISTAKES = get_args(Mistake)


class RosRobotParameters(WorldParameters):
    """What the robot is called by, how the world is, and what is wrong with the robot on purpose.

    The mistakes, each of which a bridge has to name before anything moves:

    - sign: the wrist's sensor tells the force that the robot exerts, not the one exerted on it.
    - turned: the sensor is mounted turned by 45 degrees about the flange.
    - joint_order: the joint states list their joints in another order in every other message.
    - tool_frame: the wrench is told in the axes of the arm's tool link, and says so.
    - emergency: the emergency stop is pressed from the start.
    - not_switchable: the arm's trajectory controller does not run, and no controller can be switched.
    - bgr8: the camera's images are bgr8, and its distortion has eight coefficients.
    - two_publishers: a second node, left over, publishes joint states as well.
    - clock: the robot's clock is an hour ahead.
    - mux_locked: a lock of twist_mux keeps every velocity of low priority from the base.
    """

    profile: str = option("tiago-ros1", "the robot's profile: its name, or the path of its file")
    transport: Transport = option(
        "", "how it is heard: ros1, rmw_zenoh, dds or none; by default ros1 for a profile of ROS 1, else rmw_zenoh"
    )
    address: str = option("", "of the middleware, in its own words; empty for the usual one of this machine")
    mistakes: tuple[Mistake, ...] = option((), f"planted ones, any of {', '.join(MISTAKES)}")
    camera_rate: float = parameter(10.0, "Hz", 1.0, 30.0, "of images; at most the profile's")
    control_rate: float = parameter(
        200.0, "Hz", 100.0, 1000.0, "at least: of the ticks in which commands are taken over and topics published"
    )

    def transport_of(self, middleware: str) -> str:
        """The transport for a profile's middleware.

        Raises:
            Refused: it is not one of that middleware's.
        """
        usual = {"ros1": ("ros1",), "ros2": ("rmw_zenoh", "dds")}[middleware]
        if self.transport not in ("", "none", *usual):
            raise Refused(
                f"transport is {self.transport}, and profile {self.profile} speaks {middleware}: "
                f"wanted {' or '.join(usual)}"
            )
        return self.transport or usual[0]

    def check(self) -> None:
        """Whether each mistake stands there once.

        Raises:
            Refused: one stands there twice.
        """
        super().check()
        twice = {name for name in self.mistakes if self.mistakes.count(name) > 1}
        if twice:
            raise Refused(f"mistakes has {', '.join(sorted(twice))} twice")
