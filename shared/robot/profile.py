"""A robot's profile: what a bridge has to know of a robot to stand for it, in one TOML file.

It names the description, the frames, the joints of the arm, and everything that the robot's middleware calls by a name:
topics, types, controllers. Whatever in it contradicts itself or the description is refused in one line, so that a
bridge never starts with it.
"""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, InstanceOf, ValidationError

from shared.parameters import Refused
from shared.robot import profile_tables as tables
from shared.robot.description import Description, Undescribed
from shared.robot.held_command import Ranges
from shared.robot.profile_tables import Name, Table

PROFILES = Path(__file__).parents[2] / "deploy/config/robots"
"""Folder of the profiles that are found by their names."""
DESCRIPTIONS = Path(__file__).parent
"""Folder of the descriptions that a profile may name besides those beside it."""

FEWEST_JOINTS = 6
"""Joints without which a tool cannot follow a twist."""
_TYPES = {
    "base": ("geometry_msgs/Twist", "geometry_msgs/TwistStamped"),
    "emergency_stop": ("std_msgs/Bool",),
    "enable": ("std_msgs/Bool", "sensor_msgs/Joy"),
}


class Profile(Table):
    """A robot, as its profile describes it; see ``shared.robot.profile_tables`` for the tables.

    Attributes:
        name: of the file, without its ending.
        description: what the file ``urdf`` says.
        base_type: ``none`` if nothing moves the arm's base.
        controllers: trajectory controllers by the names that the profile gives them.
    """

    name: str
    description: Annotated[InstanceOf[Description], Field(repr=False)]
    urdf: InstanceOf[Path]
    middleware: Literal["ros1", "ros2"]
    base_type: Literal["differential", "omni", "none"]
    frames: tables.Frames
    arm: tables.Arm
    joints: tables.Stream
    wrench: tables.WrenchStream
    controllers: Mapping[Name, tables.Controller]
    head: tables.Head | None = None
    gripper: tables.Gripper | None = None
    base: tables.Base | None = None
    camera: tables.Camera | None = None
    emergency_stop: tables.EmergencyStop | None = None
    enable: tables.EnableDevice | None = None
    switching: tables.Switching | None = None

    @classmethod
    def load(cls, which: str) -> Profile:
        """A profile by its name among those shipped, or by the path of its file.

        Raises:
            Refused: there is none, it cannot be read, or it is contradictory; one line that names file, table, field.
        """
        path = _file(which)
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as problem:
            raise Refused(f"robot profile {path}: {problem.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
            raise Refused(f"robot profile {path}: not TOML ({problem})") from None
        return cls.of(content, path)

    @classmethod
    def of(cls, content: Mapping[str, Any], path: Path) -> Profile:
        """A profile of the content of its file.

        Raises:
            Refused: as ``load``.
        """
        try:
            urdf = _urdf(path, content.get("urdf"))
            of_files = {"name": path.stem, "urdf": urdf, "description": Description.of(urdf)}
            if taken := of_files.keys() & content.keys() - {"urdf"}:
                raise Refused(f"{min(taken)} is not known here; misspelt?")
            profile = cls(**{**content, **of_files})
            wrong = next(profile._contradictions(), "")
        except ValidationError as problem:
            wrong = _one_line(problem)
        except (Undescribed, Refused) as problem:
            wrong = str(problem)
        if wrong:
            raise Refused(f"robot profile {path}: {wrong}")
        return profile

    def ros_type(self, name: str) -> str:
        """A type ``package/Type`` as the profile's middleware writes it."""
        return name if self.middleware == "ros1" else name.replace("/", "/msg/")

    def heard(self) -> dict[str, str]:
        """Topics that the robot publishes, as far as the profile names them, with their types."""
        return dict(self._heard())

    def commanded(self) -> dict[str, str]:
        """Topics that the robot is commanded by, with their types."""
        return dict(self._commanded())

    def _heard(self) -> Iterator[tuple[str, str]]:
        yield self.joints.topic, self.ros_type("sensor_msgs/JointState")
        yield self.wrench.topic, self.ros_type("geometry_msgs/WrenchStamped")
        if self.base:
            yield self.base.odometry, self.ros_type("nav_msgs/Odometry")
        if self.camera:
            compressed = "Compressed" if self.camera.image.endswith("/compressed") else ""
            yield self.camera.image, self.ros_type(f"sensor_msgs/{compressed}Image")
            yield self.camera.info, self.ros_type("sensor_msgs/CameraInfo")
        for table in (self.emergency_stop, self.enable):
            if table:
                yield table.topic, table.type

    def _commanded(self) -> Iterator[tuple[str, str]]:
        for controller in self.controllers.values():
            yield controller.topic, self.ros_type("trajectory_msgs/JointTrajectory")
        if self.base:
            yield self.base.topic, self.base.type

    def arm_controllers(self) -> dict[str, tuple[int, ...]]:
        """The controllers of the arm's joints: of each of its joints in its order the place in ``arm.joints``."""
        places = {joint: place for place, joint in enumerate(self.arm.joints)}
        return {
            name: tuple(places[joint] for joint in controller.joints)
            for name, controller in self.controllers.items()
            if controller.joints[0] in places
        }

    def gripper_ranges(self) -> Ranges:
        """Ranges of a gripper command [m, N]; of nothing if there is none."""
        nothing = (0.0, 0.0)
        gripper = self.gripper
        return {
            "opening": gripper.opening if gripper else nothing,
            "effort": gripper.effort if gripper else nothing,
        }

    def head_ranges(self) -> Ranges:
        """Ranges of a head command [rad]; of nothing if there is none."""
        limits = [self.description.joints[joint] for joint in self.head.joints] if self.head else []
        spans = [(limit.lower, limit.upper) for limit in limits] or [(0.0, 0.0)] * 2
        return dict(zip(("pan", "tilt"), spans, strict=True))

    def _contradictions(self) -> Iterator[str]:
        yield from self._wrong_frames()
        yield from self._wrong_joints()
        yield from self._wrong_controllers()
        if (self.base is None) != (self.base_type == "none"):
            yield f'base_type is "{self.base_type}", ' + ("but there is a [base]" if self.base else "wanted a [base]")
        if self.base and self.base_type == "differential" and self.base.sideways:
            yield f"[base] sideways is {self.base.sideways:g}, but a differential base goes 0 m/s sideways"
        for table, allowed in _TYPES.items():
            given, wanted = getattr(self, table), [self.ros_type(kind) for kind in allowed]
            if given and given.type not in wanted:
                yield f"[{table}] type is {given.type}, under {self.middleware} wanted {' or '.join(wanted)}"
        if self.switching and self.middleware == "ros2":
            yield "[switching] is of ros1: under ros2 the robot's own launch files start controllers"
        topics = [topic for topic, _ in (*self._heard(), *self._commanded())]
        if twice := [topic for topic in topics if topics.count(topic) > 1]:
            yield f"topic {twice[0]} is named twice"

    def _wrong_frames(self) -> Iterator[str]:
        frames, robot = self.frames, self.description
        for field, frame in frames.model_dump(exclude_defaults=True).items():
            if not robot.has_frame(frame):
                yield f"[frames] {field} is {frame}, which {self.urdf.name} has not"
        if frames.base != robot.root:
            yield f"[frames] base is {frames.base}, wanted {robot.root}, the root of {self.urdf.name}"
        if not robot.carries(frames.sensor, frames.tool):
            yield f"[frames] sensor is {frames.sensor}, which does not carry the tool {frames.tool}"
        if robot.chain(frames.sensor) != robot.chain(frames.tool):
            yield f"[frames] a joint moves the tool {frames.tool} relative to the sensor {frames.sensor}"

    def _wrong_joints(self) -> Iterator[str]:
        arm, robot, file = self.arm, self.description, self.urdf.name
        chain = robot.chain(self.frames.tool)
        if len(arm.joints) < FEWEST_JOINTS:
            yield f"[arm] joints are {len(arm.joints)}, wanted {FEWEST_JOINTS} at least: fewer follow no twist"
        for table in ("arm", "head", "gripper"):
            for joint in getattr(getattr(self, table), "joints", ()):
                if joint not in robot.joints:
                    yield f"[{table}] joint {joint} is none that moves in {file}; there are {', '.join(robot.joints)}"
        if arm.joints != chain:
            yield f"[arm] joints are {', '.join(arm.joints)}, but to {self.frames.tool} lead {', '.join(chain)}"
        for field in ("acceleration", "home", "weight", "margin", "speed"):
            values = getattr(arm, field)
            if len(values) != len(arm.joints) and (values or field == "acceleration"):
                yield f"[arm] {field} has {len(values)} elements, wanted one for each of {len(arm.joints)} joints"
            if field != "home" and field != "margin" and not all(values):
                yield f"[arm] {field} has a 0, wanted positive numbers"
        for joint, place in zip(arm.joints, arm.home, strict=False):
            limit = robot.joints[joint]
            if not limit.lower <= place <= limit.upper:
                yield f"[arm] home of {joint} is {place:g}, in {file} it goes from {limit.lower:g} to {limit.upper:g}"
        if arm.lift and (arm.lift.joint not in arm.joints or not arm.home):
            yield f"[arm.lift] joint is {arm.lift.joint}, wanted one of [arm] joints, and a [arm] home"
        if math.inf in (abs(bound) for joint in arm.joints for bound in robot.joints[joint][:2]):
            yield f"[arm] a joint turns without end in {file}, wanted limits"

    def _wrong_controllers(self) -> Iterator[str]:
        arm = self.arm.joints
        owned = [joint for controller in self.controllers.values() for joint in controller.joints]
        for name, controller in self.controllers.items():
            for joint in controller.joints:
                if joint not in self.description.joints:
                    yield f"[controllers.{name}] joint {joint} is none that moves in {self.urdf.name}"
                if owned.count(joint) > 1:
                    yield f"[controllers.{name}] joint {joint} has more than one controller"
                if (joint in arm) != (controller.joints[0] in arm):
                    yield f"[controllers.{name}] {joint} and {controller.joints[0]} are not both of [arm] joints"
        for joint in arm:
            if joint not in owned:
                yield f"[controllers] none has {joint} of [arm] joints"
        for table in ("head", "gripper"):
            if (part := getattr(self, table)) is None:
                continue
            if part.controller not in self.controllers:
                yield f"[{table}] controller is {part.controller}, there are {', '.join(self.controllers)}"
            elif sorted(part.joints) != sorted(self.controllers[part.controller].joints):
                yield f"[{table}] joints are not those of [controllers.{part.controller}]"


def _file(which: str) -> Path:
    if which.endswith(".toml") or "/" in which:
        return Path(which)
    shipped = sorted(path.stem for path in PROFILES.glob("*.toml"))
    if which not in shipped:
        raise Refused(f"robot profile {which}: there are {', '.join(shipped)}, or the path of a .toml file")
    return PROFILES / f"{which}.toml"


def _urdf(profile: Path, name: Any) -> Path:
    if not isinstance(name, str):
        raise Refused("urdf is missing, wanted the name of a file")
    for folder in (profile.parent, DESCRIPTIONS):
        if os.path.isfile(folder / name):
            return folder / name
    raise Refused(f"urdf is {name}: neither in {profile.parent} nor in {DESCRIPTIONS}")


def _one_line(problem: ValidationError) -> str:
    """What is wrong first, as table and field."""
    first = problem.errors()[0]
    *above, last = [str(part) for part in first["loc"]]
    where = f"[{'.'.join(above)}] {last}" if above else f"[{last}]" if isinstance(first["input"], dict) else last
    if first["type"] == "extra_forbidden":
        return f"{where} is not known here; misspelt?"
    if first["type"] == "missing":
        return f"{where if above else f'{last}, or a table of that name,'} is missing"
    return f"{where} is {str(first['input'])[:60]}: {first['msg'][0].lower()}{first['msg'][1:]}"
