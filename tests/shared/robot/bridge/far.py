"""A robot for bridges under simulated time: trajectory controllers that follow their splines, and no physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from services.ros_robot.messages import Point, Trajectory
from services.ros_robot.trajectory_controller import JointTrajectoryController
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import RobotStatus, Stop, TwistCommand
from shared.robot.bridge.arm import kinematics_of
from shared.robot.bridge.bridge import Bridge
from shared.robot.bridge.parameters import BridgeParameters
from shared.robot.far_side import Calibration, Heard, Joints, Odometry, Picture, TrajectoryPoint, Wrench
from shared.robot.profile import Profile
from shared.spatial import GRAVITY
from shared.topics import COMMAND_EE_TWIST, STATE_ROBOT, STOP, WRENCH_TARE
from shared.wire.codec import decode_map, encode_map

CONTROL = 0.002  # [s] of the controllers
WALL = 1_700_000_000 * 10**9  # [ns] of the wall clock at the start


class FarRobot:
    """The far side of a bridge, as it meets a healthy robot; what is wrong with it is set by the tests.

    Attributes:
        position: of every joint that the description has, by name [rad, m].
        applied: force (3,) [N], base axes, on the tool, besides the weight of what is beyond the sensor.
        between: width [m] of what keeps the fingers from closing.
        sag: by which the arm's joints are told below where their controllers have them [rad, m].
        published: whether joints, wrench and odometry come.
        kept: what it is told is kept on the way, if that is no None.
        turned: rotation (3, 3) of the sensor's axes against where they should be.
    """

    def __init__(self, profile: Profile, stack: Stack) -> None:
        self.profile, self.stack = profile, stack
        joints = profile.description.joints
        self.position = {name: min(max(0.0, limit.lower), limit.upper) for name, limit in joints.items()}
        home = profile.arm.home or (0.0, -1.57, 1.57, 0.0, 1.57, 0.0)
        self.position |= dict(zip(profile.arm.joints, home, strict=True))
        self.velocity = dict.fromkeys(joints, 0.0)
        self.controllers = {
            name: JointTrajectoryController(
                profile.middleware, name, row.joints, np.array([self.position[joint] for joint in row.joints])
            )
            for name, row in profile.controllers.items()
        }
        for controller in self.controllers.values():
            controller.running = True
        self.kinematics = kinematics_of(profile)
        self.weight = GRAVITY * profile.description.mass_beyond(profile.frames.sensor)
        self.applied = np.zeros(3)
        self.between = self.sag = 0.0
        self._speeds: list[float] | None = None
        self.turned = np.eye(3)
        self.published = {"joints", "wrench", "odometry"}
        self.names = tuple(joints)
        self.frame = profile.frames.sensor
        self.sender = "/robot"
        self.clock_ahead = 0
        self.base_works = True
        self.driven = np.zeros(3)
        self.kept: list[tuple[str, Sequence[TrajectoryPoint]]] | None = None
        self.moves: list[tuple[float, str, Sequence[TrajectoryPoint]]] = []
        self.drives: list[tuple[float, np.ndarray]] = []
        self.pressed_by, self.unready = "", ""
        self.wrong: tuple[str, ...] = ()
        self.shot: tuple[Heard[Picture], Heard[Calibration]] | None = None
        self.wanted: list[bool] = []
        self.closed = False
        self._heard: dict[str, Heard[Any]] = {}
        for name, rate, measure in (
            ("joints", profile.joints.rate, self._joints),
            ("wrench", profile.wrench.rate, self._wrench),
            ("odometry", 50.0, self._odometry),
        ):
            self._every(1.0 / rate, lambda name=name, measure=measure: self._publish(name, measure))
        self._every(CONTROL, self._control)

    @property
    def arm(self) -> np.ndarray:
        return np.array([self.position[joint] for joint in self.profile.arm.joints])

    @property
    def arm_speed(self) -> float:
        """Largest speed of the arm's joints [rad/s, m/s]."""
        return max(abs(self.velocity[joint]) for joint in self.profile.arm.joints)

    @property
    def tool(self) -> np.ndarray:
        self.kinematics.update(self.arm)
        return self.kinematics.tool_position()

    def heal(self) -> None:
        """Be a healthy robot again."""
        self.pressed_by = self.unready = ""
        self.published = {"joints", "wrench", "odometry"}
        self.names = tuple(self.profile.description.joints)

    def cut(self) -> None:
        """Let nothing through in either direction, as if what stands on the way had been stopped."""
        self.published, self.kept = set(), []

    def mend(self) -> None:
        """Let everything through again, what was told meanwhile first."""
        kept, self.kept = self.kept or (), None
        for controller, points in kept:
            self.move(controller, points)
        self.heal()

    def tell_all_but(self, joint: str) -> None:
        """Leave a joint out of the joint states."""
        self.names = tuple(name for name in self.names if name != joint)

    def lead(self, place: np.ndarray) -> None:
        """Somebody else leads the arm elsewhere."""
        there = dict(zip(self.profile.arm.joints, place.tolist(), strict=True))
        for name in self.profile.arm_controllers():
            controller = self.controllers[name]
            controller.hold(np.array([there[joint] for joint in controller.joints]))

    def log_speeds(self) -> list[float]:
        """Speeds [rad/s] of the elbow from now on, at every step of the controllers."""
        self._speeds = []
        return self._speeds

    def _every(self, period: float, turn: Callable[[], None]) -> None:
        def again() -> None:
            turn()
            self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(period), again)

        self.stack.scheduler.soon(again)

    def _control(self) -> None:
        for controller in self.controllers.values():
            position, velocity = controller.sample(self.stack.now)
            self.position |= dict(zip(controller.joints, position.tolist(), strict=True))
            self.velocity |= dict(zip(controller.joints, velocity.tolist(), strict=True))
        if self._speeds is not None:
            self._speeds.append(self.velocity[self.profile.arm.joints[4]])
        if self.profile.gripper:
            for joint in self.profile.gripper.joints:
                self.position[joint] = max(self.position[joint], 0.5 * self.between)

    def publish(self, name: str, message: Any, sender: str) -> None:
        """Let a message arrive."""
        now = self.stack.scheduler.clock.now_ns()
        number = self._heard[name].number + 1 if name in self._heard else 1
        self._heard[name] = Heard(message, number, now, WALL + now + self.clock_ahead, sender)

    def _publish(self, name: str, measure: Callable[[], Any]) -> None:
        if name in self.published:
            self.publish(name, measure(), self.sender)

    def _joints(self) -> Joints:
        told = {name: place - self.sag * (name in self.profile.arm.joints) for name, place in self.position.items()}
        values = [np.array([table[name] for name in self.names]) for table in (told, self.velocity)]
        return Joints(self.names, *values, np.zeros(len(self.names)))

    def _wrench(self) -> Wrench:
        self.kinematics.update(self.arm)
        _, rotation = self.kinematics.sensor()
        force = (self.applied - (0.0, 0.0, self.weight)) @ rotation
        return Wrench(self.turned @ force, np.zeros(3), self.frame)

    def _odometry(self) -> Odometry:
        return Odometry(np.zeros(2), 0.0, self.driven if self.base_works else np.zeros(3))

    def joints(self) -> Heard[Joints] | None:
        return self._heard.get("joints")

    def wrench(self) -> Heard[Wrench] | None:
        return self._heard.get("wrench")

    def odometry(self) -> Heard[Odometry] | None:
        return self._heard.get("odometry")

    def picture(self, wanted: bool) -> tuple[Heard[Picture], Heard[Calibration]] | None:
        self.wanted.append(wanted)
        return self.shot

    def emergency(self) -> str:
        return self.pressed_by

    def pressed(self) -> Heard[bool] | None:
        return self._heard.get("pressed")

    def move(self, controller: str, points: Sequence[TrajectoryPoint]) -> None:
        if self.kept is not None:
            self.kept.append((controller, points))
            return
        now = self.stack.now
        self.moves.append((now, controller, points))
        knots = tuple(Point(point.after, point.position, point.velocity) for point in points)
        message = Trajectory(self.profile.controllers[controller].joints, knots)
        assert self.controllers[controller].command(message, now, now) == ""

    def drive(self, velocity: np.ndarray) -> None:
        self.drives.append((self.stack.now, velocity))
        self.driven = velocity

    def ready(self) -> str:
        return self.unready

    def mismatches(self) -> Sequence[str]:
        return self.wrong

    def refusals(self) -> Mapping[str, str]:
        return {}

    def close(self) -> None:
        self.closed = True


class BridgeRig:
    """A bridge and its robot on a stack of their own; a person releases its stop."""

    def __init__(self, profile: str = "tiago-ros1", **parameters: Any) -> None:
        self.stack = Stack()
        clock = self.stack.scheduler.clock

        def make(known: Profile, _: BridgeParameters) -> FarRobot:
            self.robot = FarRobot(known, self.stack)
            return self.robot

        chosen = BridgeParameters.of({"profile": profile, "require_enable": False} | parameters)
        self.bridge = Bridge(chosen, make, clock, lambda: WALL + clock.now_ns())
        self.runner = self.stack.add(self.bridge)
        self.told: list[RobotStatus] = []
        self.stack.client.watch(STATE_ROBOT, lambda received: self.told.append(received.message))

    @property
    def status(self) -> RobotStatus:
        return self.told[-1]

    def release(self) -> None:
        """`tandem resume`."""
        self.stack.run(0.1)
        self.stack.client.publish(STOP, Stop(False, ""))
        self.stack.run(0.1)

    def drive(
        self, linear: tuple[float, float, float], duration: float, beside: Callable[[], None] = lambda: None
    ) -> None:
        """Command a twist at 100 Hz, and do something else beside."""
        for _ in range(round(duration / 0.01)):
            beside()
            self.stack.client.publish(COMMAND_EE_TWIST, TwistCommand(linear, (0.0, 0.0, 0.0), 0.05))
            self.stack.run(0.01)

    def tare(self) -> None:
        """`tandem tare`."""
        answers: list[dict[str, Any]] = []
        request = encode_map({"duration": 0.5})
        self.stack.bus.query_later(WRENCH_TARE.key, request, lambda reply: answers.append(decode_map(reply)))
        self.stack.run(1.0)
        assert answers[0]["ok"], answers

    def hang(self, duration: float) -> None:
        """Let the bridge do nothing for a while, as if its process had been stopped."""
        until = self.stack.scheduler.clock.now_ns() + nanoseconds(duration) + 1
        hung = {"poll": lambda behind=False: None, "next_deadline": lambda: until}
        vars(self.runner).update(hung)
        self.stack.run(duration)
        for name in hung:
            del vars(self.runner)[name]

    def stop(self) -> None:
        self.stack.client.publish(STOP, Stop(True, "test"))
