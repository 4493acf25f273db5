"""The toy robot behind the contract: publishes what the task needs, does what it commands; with faults."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from shared import topics
from shared.messages import CameraImage, ControlStatus, EndEffector, ExternalWrench, RobotStatus
from shared.schema.records import Record
from shared.spatial import rotation_from_vector
from shared.wire.subscription import Received
from tests.services.task.scene import Camera, Light, Print, message, render
from tests.services.task.toy import MARKER, Toy

TICK = 0.01
HEAD = Pose.from_rpy((0.2, 0.0, 1.3), (-2.2, 0.0, -1.9))
"""The camera's optical frame in base: looks ahead, down and to the right, at the panel."""
EYE = np.array((0.0, -0.06, 0.06))
"""The camera [m] from where the head's axes cross, in its optical axes."""
_STILL = np.zeros(6)


class Robot:
    """Robot, wrench service, controller and person in one.

    Attributes:
        muted: keys that are not published any more.
        every: ticks between two wrenches, and two statuses of the controller.
        compensation, zero_age, error_bound: what the wrench service says.
        control: state of the controller while it does not brake.
        shown: marker pose in base that the camera sees; None covers it.
        number: of that marker.
        marker_size: side [m] of its square.
        frozen: whether the camera sends one image again and again, under fresh stamps.
        valid: whether images are marked as valid.
        turns: whether the head does what it is told.
        reports: what the camera's messages say otherwise than it is.
        denies: whether the gripper says that it holds nothing, whatever it does.
        received: every message of each key that the task publishes.
    """

    OUTPUTS = (
        topics.CONTROL_TARGET,
        topics.BASE_ENABLE,
        topics.COMMAND_GRIPPER,
        topics.COMMAND_HEAD,
        topics.TASK_STATUS,
    )

    def __init__(self, watch: Callable[..., Any], parameters: TaskParameters | None = None) -> None:
        self.toy = Toy(parameters)
        self.muted: set[str] = set()
        self.every = 1
        self.compensation = "payload"
        self.zero_age: float | None = None
        self.error_bound = np.full(6, 0.2)
        self.wrench_fault = ""
        self.braking = ""
        self.control = "tracking"
        self.mode = "ready"
        self.shown: Pose | None = MARKER
        self.number = self.toy.parameters.marker_id
        self.marker_size = self.toy.parameters.marker_size
        self.received: dict[str, list[Received]] = {topic.key: [] for topic in self.OUTPUTS}
        self.frozen, self.valid, self.denies = False, True, False
        self._sent: CameraImage | None = None
        self._pictures = 0
        self.turns, self.reports = True, lambda image: image
        self.head = HEAD
        for topic in self.OUTPUTS:
            watch(topic, self.received[topic.key].append)

    def last(self, topic: topics.Topic) -> Any:
        """The newest message of a topic, None before the first."""
        return next((received.message for received in self.received[topic.key][-1:]), None)

    @property
    def state(self) -> str:
        """Of the task, as it says."""
        status = self.last(topics.TASK_STATUS)
        return status.state if status else ""

    @property
    def reason(self) -> str:
        """Of the task, as it says."""
        status = self.last(topics.TASK_STATUS)
        return status.reason if status else ""

    def tick(self, number: int) -> list[tuple[topics.Topic, Record, bool]]:
        """Move for one tick of 10 ms; topic, message and validity of what is to be published."""
        self._obey()
        toy = self.toy
        toy.advance(TICK)
        wrench = toy.wrench
        messages: list[tuple[topics.Topic, Record, bool]] = [(topics.STATE_EE, self._tool(), True)]
        if number % self.every == 0:
            known = (self.error_bound, self.compensation, self.wrench_fault, self.zero_age)
            felt = ExternalWrench(wrench[:3], wrench[3:], *known)
            messages.append((topics.WRENCH_EXTERNAL, felt, not self.wrench_fault))
            messages.append((topics.CONTROL_STATUS, self._status(), True))
        if number % 5 == 0:
            gripper = toy.gripper.replaced(holding=False) if self.denies else toy.gripper
            messages.append((topics.STATE_GRIPPER, gripper, True))
        if number % 20 == 0:
            robot = RobotStatus(self.mode, "", "omni", True, 0.3, 1.0, np.array((0.5, 0.5, 0.5)))
            messages.append((topics.STATE_ROBOT, robot, True))
        if number % 10 == 0:
            if self._sent is None or not self.frozen:
                self._sent = self._another(self._image())
            messages.append((topics.SENSOR_CAMERA, self._sent, self.valid))
        return [item for item in messages if item[0].key not in self.muted]

    def show(self, marker: Pose) -> None:
        """Move the marker. Its picture is made in this thread: the one that publishes would be silent for too long."""
        self._picture(marker, self.number)
        self.shown = marker

    def person(self) -> None:
        """Do what the task waits for: lift, turn by 90 degrees, lower."""
        toy = self.toy
        if self.state != "carrying":
            return
        toy.lifted = True
        status = self.last(topics.TASK_STATUS)
        if abs(status.rotation) > 1.5:
            toy.roll_rate, toy.far_height = 0.0, toy.stands
        elif "carrying;" in status.reason:
            toy.roll_rate = 0.4

    def _obey(self) -> None:
        # As a controller does: a target that is marked invalid is none.
        targets = (received for received in reversed(self.received[topics.CONTROL_TARGET.key]))
        target = next((received.message for received in targets if received.header.valid), None)
        grip = self.last(topics.COMMAND_GRIPPER)
        moves = target is not None and not self.braking and not self.wrench_fault
        self.toy.target = Pose.of(target.position, target.orientation) if moves else None
        if grip is not None:
            self.toy.wanted = grip.opening
        head = self.last(topics.COMMAND_HEAD)
        if head is not None and self.turns:
            self.head = looking(head.pan, head.tilt, self.toy.parameters)

    def _tool(self) -> EndEffector:
        toy = self.toy
        linear, angular = np.array((toy.speed, 0.0, 0.0)), np.array((toy.turning, 0.0, 0.0))
        return EndEffector(toy.tool.position, toy.tool.orientation, linear, angular)

    def _status(self) -> ControlStatus:
        state = "braking" if self.braking else self.control
        return ControlStatus(state, self.braking, "certified", _STILL, _STILL, _STILL, 0.0, 0.0, 50.0)

    def _another(self, image: CameraImage) -> CameraImage:
        """The same picture with a comment in it: in place of the noise, by which each of a real camera differs."""
        self._pictures += 1
        comment = b"\xff\xfe\x00\x06" + self._pictures.to_bytes(4, "big")
        return image.replaced(data=image.data[:2] + comment + image.data[2:])

    def _image(self) -> CameraImage:
        return self.reports(self._picture(self.shown, self.number))

    def _picture(self, shown: Pose | None, number: int) -> CameraImage:
        in_camera = None if shown is None else tuple((self.head.inverse @ shown).row.round(9).tolist())
        picture = _picture(in_camera, self.marker_size, number)
        return picture.replaced(position=self.head.position, orientation=self.head.orientation)


def looking(pan: float, tilt: float, parameters: TaskParameters) -> Pose:
    """The camera in base, with the head's joints at these angles [rad]."""
    pivot = HEAD.position - HEAD.rotation @ EYE
    panned = rotation_from_vector((0.0, 0.0, pan - parameters.head_pan))
    rotation = panned @ HEAD.rotation @ rotation_from_vector((tilt - parameters.head_tilt, 0.0, 0.0))
    return Pose(pivot + rotation @ EYE, rotation)


@cache
def _picture(in_camera: tuple[float, ...] | None, size: float, number: int) -> CameraImage:
    prints = [] if in_camera is None else [Print(Pose.from_row(np.array(in_camera)), size, number)]
    return message(render(prints, Light()), Camera())
