"""The simulated TIAGo behind its ROS interface: what arrives on its topics moves it, and it publishes what it measures.

Nothing here knows how messages travel. An adapter for a middleware does three things with a ``RosRobot``: it hands to
``command`` what arrives on ``subscriptions``, it answers the controller manager's services with ``listed`` and
``switch``, and it publishes what each ``tick`` returns. Any thread may call any method.

- A message acts from the tick on that follows its arrival.
- ``subscriptions`` and ``publications`` name all topics with their ROS types, ``std_msgs/Bool``; ROS 2 puts ``msg``
  in between.
- A second ``Publication.node`` has to be a node of its own: it is a planted mistake.
- ``PRESS`` is no topic of a TIAGo's: it is the hand on the emergency stop.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence

from services.ros_robot.base_controller import BaseController
from services.ros_robot.controller_manager import STRICT, ControllerManager
from services.ros_robot.messages import (
    Command,
    ControllerState,
    Flag,
    Publication,
    Trajectory,
    Velocities,
)
from services.ros_robot.parameters import RosRobotParameters
from services.ros_robot.sensors import JOINT_STATE, Sensors
from services.ros_robot.twist_mux import TwistMux
from services.sim.camera.head_camera import DirectRendering, Rendering
from services.sim.camera.view import Scenery
from services.sim.pace import Ticks
from services.sim.robot.arm import JointSetPoint
from services.sim.robot.kinematics import CARRY_HOME, FULL_HOME, HOME
from services.sim.scene.panel_scene import PanelScene
from services.sim.scene.world import World
from services.sim.sim_commands import Commands
from shared.parameters import Refused
from shared.robot.profile import Profile
from shared.robot.tiago import BASES, CHAIN, FINGER_EFFORT, FINGERS, HEAD, URDF
from shared.schema.records import Record
from shared.sim_messages import Reset, SimWorld

PRESS = "/simulation/emergency_stop"
"""Topic of a Bool: somebody presses the emergency stop, or releases it."""
MUX_LOCK = "/pause_navigation"
"""The lock of twist_mux that the planted mistake engages."""
_STARTS = {"full": FULL_HOME, "load": HOME, "carry": CARRY_HOME}


class RosRobot:
    """The robot; see above.

    Attributes:
        subscriptions, publications: ROS types of all topics by their names.
        rate: of the ticks [Hz].

    Args:
        profile: how the robot calls things; of a TIAGo.
        parameters: of the world and the sensors, and the planted mistakes.
        rendering: makes what renders the camera's pictures.
        clock: [ns] the robot's clock; that of its world, counted from zero, if there is none.

    Raises:
        Refused: the profile is of another robot.
    """

    def __init__(
        self,
        profile: Profile,
        parameters: RosRobotParameters,
        rendering: Callable[[Scenery], Rendering] = DirectRendering,
        clock: Callable[[], int] | None = None,
    ) -> None:
        if profile.urdf.resolve() != URDF.resolve():
            raise Refused(f"profile {profile.name} describes {profile.urdf.name}; simulated is a TIAGo, {URDF.name}")
        self._profile = profile
        self._lock = threading.RLock()
        self._ticks = Ticks(profile.wrench.rate, parameters.control_rate, parameters.physics_rate)
        self.rate = self._ticks.rate
        scene = PanelScene(parameters.panel_scene(), self._ticks.step) if parameters.scene != "load" else None
        self._world = World(self._ticks.step, _STARTS[parameters.scene], scene, parameters.floor_slope)
        self._sensors = Sensors(profile, parameters, self._world, rendering, clock or self._own_clock)
        mistakes = parameters.mistakes
        self._manager = ControllerManager(profile, self._world.start, "not_switchable" not in mistakes)
        self._mux = TwistMux()
        self._base = BaseController(BASES["omni" if profile.base_type == "omni" else "differential"])
        self._world_commands = Commands(self._world, self._sensors.lines)
        self._pressed = "emergency" in mistakes
        self._told_pressed: bool | None = None
        self._refusals: dict[str, tuple[int, str]] = {}
        if "mux_locked" in mistakes:
            self._mux.lock(MUX_LOCK, True, 0.0)
        if self._pressed:
            self._press(True)
        self.subscriptions: Mapping[str, str] = self._subscribed()
        self.publications: Mapping[str, str] = self._published()

    def command(self, topic: str, message: Command) -> str:
        """Take over what arrived on one of the ``subscriptions``.

        Returns:
            Why it has no effect; empty if it has one. It is kept for ``refusals``.
        """
        with self._lock:
            refusal = self._taken(topic, message)
            if refusal:
                count, _ = self._refusals.get(topic, (0, ""))
                self._refusals[topic] = count + 1, refusal
            return refusal

    def listed(self) -> tuple[ControllerState, ...]:
        """Reply of ``/controller_manager/list_controllers``."""
        with self._lock:
            return self._manager.listed()

    def switch(self, start: Sequence[str], stop: Sequence[str], strictness: int = STRICT) -> bool:
        """Reply of ``/controller_manager/switch_controller``."""
        with self._lock:
            return self._manager.switch(start, stop, strictness)

    def tick(self, watched: bool = False) -> list[Publication]:
        """Let ``1 / rate`` seconds pass; what is due to be published.

        Args:
            watched: whether anybody subscribes to the camera's images; otherwise none is made.
        """
        with self._lock:
            for _ in range(self._ticks.substeps):
                self._advance()
            self._ticks.advance()
            return [*self._emergency_told(), *self._sensors.read(self._ticks, watched)]

    def carry_out(self, request: Record) -> None:
        """What the contract's ``sim/command`` asks of the world.

        Raises:
            Refused: it cannot be done; one line.
        """
        with self._lock:
            self._world_commands.carry_out(request)
            if isinstance(request, Reset):
                self._manager.set_back(self._positions())
                self._base.halt()

    def world(self) -> SimWorld:
        """What is true: the contract's ``sim/world``."""
        with self._lock:
            camera = self._sensors.camera
            return self._world.told(camera is not None and camera.marker_visible())

    def refusals(self) -> Mapping[str, tuple[int, str]]:
        """How many commands had no effect, and why the last one had none, by topic."""
        with self._lock:
            return dict(self._refusals)

    def _taken(self, topic: str, message: Command) -> str:
        now = self._world.time
        if isinstance(message, Flag):
            if topic == PRESS:
                self._press(message.value)
            elif topic in self._mux.locks:
                self._mux.lock(topic, message.value, now)
            return "" if topic in self.subscriptions else f"{topic} is none of the robot's topics"
        if isinstance(message, Trajectory | Velocities):
            start = getattr(message, "start", None)
            return self._manager.command(topic, message, now, now if start is None else self._seconds(start))
        if self._pressed:
            return "the emergency stop is pressed"
        if topic in self._mux.sources and not self._mux.passes(topic, now):
            return f"twist_mux: {self._mux.held_by(topic, now) or 'another source'} has priority"
        stamp = None if message.stamp is None else self._seconds(message.stamp)
        return self._base.command(message.velocity, now, stamp)

    def _own_clock(self) -> int:
        return round(self._world.time * 1e9)

    def _seconds(self, stamp: int) -> float:
        """A stamp of the robot's clock as time [s] of the world."""
        return self._world.time - 1e-9 * (self._sensors.stamp() - stamp)

    def _advance(self) -> None:
        world, manager, step = self._world, self._manager, self._ticks.step
        manager.advance(world.time + step, step)
        set_points, speeds = manager.position, manager.velocities
        if not self._pressed:
            world.gripper.command(sum(set_points[finger] for finger in FINGERS), FINGER_EFFORT)
            world.head.command(*(set_points[joint] for joint in HEAD))
        arm = JointSetPoint([set_points[joint] for joint in CHAIN], [speeds[joint] for joint in CHAIN])
        world.advance(arm, self._base.advance(world.time, step), self._pressed)

    def _press(self, pressed: bool) -> None:
        """Press the emergency stop or release it: everything stays where it is then, also after the release.

        Fingers that hold something go on closing on it.
        """
        self._pressed = pressed
        positions = self._positions()
        if self._world.gripper.holding:
            positions = {joint: place for joint, place in positions.items() if joint not in FINGERS}
        self._manager.press(pressed, positions)
        self._base.halt()
        self._world.gripper.stay()
        self._world.head.stay()

    def _positions(self) -> dict[str, float]:
        world = self._world
        positions = dict(zip(CHAIN, world.arm.physics.positions, strict=True))
        positions |= zip(FINGERS, (world.gripper.left, world.gripper.right), strict=True)
        return positions | dict(zip(HEAD, world.head.position.tolist(), strict=True))

    def _emergency_told(self) -> list[Publication]:
        row = self._profile.emergency_stop
        if row is None or self._told_pressed is self._pressed:
            return []
        self._told_pressed = self._pressed
        value = Flag(self._pressed == row.pressed)
        return [Publication(row.topic, "std_msgs/Bool", value, self._sensors.stamp(), latched=row.latched)]

    def _subscribed(self) -> dict[str, str]:
        profile = self._profile
        topics = dict.fromkeys(self._manager.trajectory, "trajectory_msgs/JointTrajectory")
        topics |= dict.fromkeys(self._manager.velocity, "std_msgs/Float64MultiArray")
        topics |= dict.fromkeys((*self._mux.locks, PRESS), "std_msgs/Bool")
        if profile.base is not None:
            own = "/mobile_base_controller/cmd_vel" + ("" if profile.middleware == "ros1" else "_unstamped")
            kind = profile.base.type.replace("/msg/", "/")
            topics |= dict.fromkeys((*self._mux.sources, own, profile.base.topic), kind)
        return topics

    def _published(self) -> dict[str, str]:
        profile = self._profile
        topics = {profile.joints.topic: JOINT_STATE, profile.wrench.topic: "geometry_msgs/WrenchStamped"}
        if profile.base is not None:
            topics[profile.base.odometry] = "nav_msgs/Odometry"
        if profile.camera is not None:
            topics |= {profile.camera.image: "sensor_msgs/Image", profile.camera.info: "sensor_msgs/CameraInfo"}
        if profile.emergency_stop is not None:
            topics[profile.emergency_stop.topic] = "std_msgs/Bool"
        return topics
