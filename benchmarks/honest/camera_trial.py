"""One camera before the real task, in simulated time: whether it goes to a marker that is not where it believes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.honest.optics import Lens, Light, encoded, picture
from benchmarks.honest.verdict import Verdict
from services.sim.robot.head import Head
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.task import Task
from shared import topics
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import (
    CameraImage,
    ControlStatus,
    EndEffector,
    ExternalWrench,
    GripperState,
    RobotStatus,
    TaskStatus,
)
from shared.parameters import Refused
from shared.robot.tiago import HEAD
from shared.wire.client import Client
from shared.wire.subscription import Received

FARTHEST, WIDEST = 0.01, math.radians(2.0)  # [m], [rad] that a believed marker may be off
PATIENCE = 25.0  # [s] in which a sound camera has to be believed
WATCHED = 1.0  # [s] of the approach that are watched
_BELIEVING = ("approaching", "grasping")
_TICK = 0.02  # [s]
_TOOL = Pose.from_rpy((0.40, -0.3, 0.9), (-math.pi / 2, 0.0, 0.0))
_STILL = np.zeros(6)
NOTHING = Pose(np.zeros(3), np.eye(3))


@dataclass
class Case:
    """A camera, its marker, and what the robot says of both.

    Attributes:
        true, told: the lens, and its calibration as the robot process states it.
        mount: true optical frame in the stated one.
        lifted: true height [m] of the head above the stated one.
        size: true side [m] of the marker, where `declared` says another.
        number: of the marker that is there.
        marker: in base.
        edit: what happens to the picture, (height, width) before it is encoded.
        freezes: time [s] after which the picture stays the same; infinite if it does not.
        model: name of the distortion's model that the robot process states.
        excuse: why what is false here is outside of all that is declared; empty if it is not.
    """

    true: Lens
    told: Lens
    declared: dict[str, Any] = field(default_factory=dict)
    sound: bool = True
    mount: Pose = NOTHING
    lifted: float = 0.0
    size: float = 0.15
    number: int = 7
    marker: Pose = NOTHING
    light: Light = field(default_factory=Light)
    encoding: str = "jpeg"
    model: str = ""
    edit: Callable[[Any], Any] = lambda image: image
    freezes: float = math.inf
    rate: float = 5.0
    torso: float = 0.2
    excuse: str = ""


class Trial:
    """Robot, wrench service and controller around the task; the head does what it is told."""

    def __init__(self, case: Case, random: np.random.Generator, service: type[Task] = Task) -> None:
        self.case, self._random = case, random
        self.stack = Stack()
        self._robot = Client(self.stack.bus, self.stack.scheduler.clock)
        start = {HEAD[0]: random.uniform(-0.3, 0.3), HEAD[1]: random.uniform(-0.3, 0.0)}
        self._head = Head(start)
        known = TaskParameters.model_fields
        parameters = TaskParameters.of({name: value for name, value in case.declared.items() if name in known})
        self.false = self.outside = self.reason = ""
        self.state, self.believed = "", 0.0
        self._worst = 1.0
        self._opening = 0.04
        self._image: CameraImage | None = None
        self._ticks = 0
        self._task = service(parameters)
        self.stack.add(self._task)
        self.stack.client.watch(topics.TASK_STATUS, self._judge)
        self.stack.client.watch(
            topics.COMMAND_HEAD, lambda told: self._head.command(told.message.pan, told.message.tilt)
        )
        self.stack.client.watch(topics.COMMAND_GRIPPER, self._grip)
        self._tick()

    def _grip(self, told: Received[Any]) -> None:
        self._opening = told.message.opening

    def _tick(self) -> None:
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(_TICK), self._tick)
        self._head.advance(_TICK)
        publish, number = self._robot.publish, self._ticks
        self._ticks += 1
        publish(topics.STATE_EE, EndEffector(_TOOL.position, _TOOL.orientation, np.zeros(3), np.zeros(3)))
        publish(topics.WRENCH_EXTERNAL, ExternalWrench(np.zeros(3), np.zeros(3), np.full(6, 0.2), "payload", "", 1.0))
        publish(
            topics.CONTROL_STATUS, ControlStatus("tracking", "", "certified", _STILL, _STILL, _STILL, 0.0, 0.0, 50.0)
        )
        if number % 2 == 0:
            publish(topics.STATE_GRIPPER, GripperState(self._opening, 0.0, False))
        if number % 10 == 0:
            publish(topics.STATE_ROBOT, RobotStatus("ready", "", "omni", True, 0.3, 1.0, np.full(3, 0.5)))
        if number % round(1.0 / (_TICK * self.case.rate)) == 0 and self.stack.bus.wanted(topics.SENSOR_CAMERA.key):
            publish(topics.SENSOR_CAMERA, self._taken())

    def _taken(self) -> CameraImage:
        case = self.case
        stated = Pose(*self._head.camera(case.torso))
        lifted = Pose(stated.position + np.array((0.0, 0.0, case.lifted)), stated.rotation)
        if self._image is None or self.stack.now < case.freezes:
            there = (lifted @ case.mount).inverse @ case.marker
            image = case.edit(picture(case.true, there, case.size, case.number, case.light, self._random))
            height, width = image.shape
            told = case.told
            calibration = (told.intrinsics, told.distortion)
            data = encoded(image, case.encoding)
            pose = (stated.position, stated.orientation, case.model)
            self._image = CameraImage(width, height, case.encoding, data, *calibration, *pose)
        return self._image.replaced(position=stated.position, orientation=stated.orientation)

    def _judge(self, received: Received[TaskStatus]) -> None:
        status = received.message
        self.state, self.reason = status.state, status.reason
        if status.state not in _BELIEVING:
            return
        self.believed = self.believed or self.stack.now
        if status.marker is None:
            return
        seen, true = Pose.of(status.marker.position, status.marker.orientation), self.case.marker
        away, turned = seen.distance(true), seen.angle(true)
        ratio = max(away / FARTHEST, turned / WIDEST)
        if ratio <= self._worst:
            return
        self._worst = ratio
        text = f"off by {away * 1e3:.0f} mm and {math.degrees(turned):.1f} degrees at {self.stack.now:.1f} s"
        if self.case.excuse:
            self.outside = f"{text}: {self.case.excuse}"
        else:
            self.false = text

    def run(self) -> None:
        """Start a carry; until its approach was watched, or it has not begun for long enough."""
        self.stack.run(1.0)
        try:
            self.stack.client.ask(topics.TASK_COMMAND, {"command": "start"}, timeout=5.0)
        except Refused as refusal:
            self.reason = str(refusal)
            return
        over = self.stack.now + PATIENCE
        self.stack.run(PATIENCE, lambda: bool(self.believed) or self.state == "holding")
        if self.believed and self.stack.now < over:
            self.stack.run(WATCHED)


def play(kind: str, seed: int, case: Case, random: np.random.Generator, service: type[Task] = Task) -> Verdict:
    """The verdict on one case."""
    try:
        trial = Trial(case, random, service)
    except Refused as refusal:
        return Verdict(kind, seed, case.sound, str(refusal))
    trial.run()
    refused = "" if trial.believed else trial.reason or f"it is {trial.state}"
    return Verdict(kind, seed, case.sound, refused, trial.false, trial.outside)
