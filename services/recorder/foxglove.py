"""Messages of the contract as Foxglove's own types: frames, pictures, poses, joints, a scene, and a log.

Frames: `world` (the base's odometry), below it `base`, and below that `tool`, `sensor`, `camera`. The scene shows what
acts on the tool in base axes: an arrow of 15 mm per newton, whose end is within the box of the limits in force.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from foxglove_schemas_protobuf.ArrowPrimitive_pb2 import ArrowPrimitive
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointState_pb2 import JointState as Joint
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from shared.messages import (
    BaseState,
    CameraImage,
    ControlStatus,
    ControlTarget,
    EndEffector,
    ExternalWrench,
    FtSample,
    JointState,
    TaskStatus,
)
from shared.schema.records import Record
from shared.sim_messages import SimWorld
from shared.spatial import Array, quaternion, quaternion_from_vector, rotation_from_vector, rotation_matrix
from shared.topics import STATE_EE

WORLD, BASE, TOOL, SENSOR, CAMERA = "world", "base", "tool", "sensor", "camera"
PER_NEWTON, PER_NEWTON_METRE = 0.015, 0.15
"""Length [m] of an arrow for 1 N and 1 Nm."""
_EDGES = ((0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7))
_LEVEL = np.array((0.0, 0.0, 0.0, 1.0))
_YELLOW, _PURPLE, _GREEN, _RED, _WOOD, _SKIN = (
    Color(r=r, g=g, b=b, a=a)
    for r, g, b, a in (
        (0.95, 0.8, 0.1, 1.0),
        (0.7, 0.3, 0.9, 1.0),
        (0.2, 0.8, 0.3, 1.0),
        (0.9, 0.1, 0.1, 1.0),
        (0.8, 0.6, 0.4, 0.5),
        (0.9, 0.6, 0.5, 1.0),
    )
)


class Shown(NamedTuple):
    """A message of Foxglove's, and its topic."""

    topic: str
    message: Any


Newest = dict[str, Record]
"""By key the newest message of the contract."""
Show = Callable[[Any, Timestamp, Newest], Iterator[Shown]]


def show(key: str, message: Record, time: int, newest: Newest) -> Iterator[Shown]:
    """What Foxglove is shown for a message at a time [ns]; ``newest`` takes note of it."""
    stamp = Timestamp(seconds=time // 10**9, nanos=time % 10**9)
    before = newest.get(key)
    newest[key] = message
    if key in _SHOWS:
        yield from _SHOWS[key](message, stamp, newest)
    yield from _logged(key, message, before, stamp)


def _frame(parent: str, child: str, position: Array, orientation: Array, stamp: Timestamp) -> Shown:
    transform = FrameTransform(
        timestamp=stamp,
        parent_frame_id=parent,
        child_frame_id=child,
        translation=_vector(position),
        rotation=_quaternion(orientation),
    )
    return Shown("/tf", FrameTransforms(transforms=[transform]))


def _base(state: BaseState, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    turned = quaternion_from_vector((0.0, 0.0, state.yaw))
    yield _frame(WORLD, BASE, np.array([*state.position, 0.0]), turned, stamp)


def _tool(state: EndEffector, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    yield _frame(BASE, TOOL, state.position, state.orientation, stamp)


def _sensor(sample: FtSample, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    tool = newest.get(STATE_EE.key)
    if isinstance(tool, EndEffector):
        origin = tool.position - rotation_matrix(sample.orientation) @ sample.tool_offset
        yield _frame(BASE, SENSOR, origin, sample.orientation, stamp)


def _camera(image: CameraImage, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    yield _frame(BASE, CAMERA, image.position, image.orientation, stamp)
    named: dict[str, Any] = {"timestamp": stamp, "frame_id": CAMERA}
    if image.encoding in ("jpeg", "png"):
        yield Shown("/camera/image", CompressedImage(**named, data=image.data, format=image.encoding))
    else:
        step = image.width * (1 if image.encoding == "mono8" else 3)
        size: dict[str, Any] = {"width": image.width, "height": image.height, "step": step}
        yield Shown("/camera/image", RawImage(**named, **size, encoding=image.encoding, data=image.data))
    fx, fy, cx, cy = image.intrinsics
    lens = "plumb_bob" if len(image.distortion) <= 5 else "rational_polynomial"
    yield Shown(
        "/camera/calibration",
        CameraCalibration(
            **named,
            width=image.width,
            height=image.height,
            distortion_model=image.distortion_model or lens,
            D=image.distortion,
            K=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            R=np.eye(3).ravel(),
            P=[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ),
    )


def _joints(state: JointState, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    rows = zip(state.name, state.position, state.velocity, state.effort, strict=True)
    joints = [Joint(name=name, position=q, velocity=v, effort=e) for name, q, v, e in rows]
    yield Shown("/joints", JointStates(timestamp=stamp, joints=joints))


def _target(target: ControlTarget, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    yield Shown("/target", PoseInFrame(timestamp=stamp, frame_id=BASE, pose=_pose(target.position, target.orientation)))


def _marker(status: TaskStatus, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    if (marker := status.marker) is not None:
        pose = _pose(marker.position, marker.orientation)
        yield Shown("/marker", PoseInFrame(timestamp=stamp, frame_id=BASE, pose=pose))


def _wrench(wrench: ExternalWrench, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    tool = newest.get(STATE_EE.key)
    if isinstance(tool, EndEffector):
        arrows = [
            _arrow(tool.position, wrench.force * PER_NEWTON, _YELLOW),
            _arrow(tool.position, wrench.torque * PER_NEWTON_METRE, _PURPLE),
        ]
        yield _scene("wrench", BASE, stamp, arrows=arrows)


def _limits(status: ControlStatus, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    tool = newest.get(STATE_EE.key)
    if not isinstance(tool, EndEffector) or status.limit is None or status.nominal is None or not status.limit.any():
        return
    centre = tool.position + status.nominal[:3] * PER_NEWTON
    half = status.limit[:3] * PER_NEWTON
    corners = [centre + half * (x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    points = [Point3(x=p[0], y=p[1], z=p[2]) for edge in _EDGES for p in (corners[end] for end in edge)]
    colour = _RED if status.active[:3].any() else _GREEN
    box = LinePrimitive(type=LinePrimitive.LINE_LIST, thickness=0.003, points=points, color=colour)
    box.pose.CopyFrom(_pose(np.zeros(3), _LEVEL))
    yield _scene("limits", BASE, stamp, lines=[box])


def _world(world: SimWorld, stamp: Timestamp, newest: Newest) -> Iterator[Shown]:
    if (panel := world.panel) is not None and panel.size.any():
        cube = CubePrimitive(pose=_pose(panel.position, panel.orientation), size=_vector(panel.size), color=_WOOD)
        yield _scene("panel", WORLD, stamp, cubes=[cube])
    if (hand := world.hand) is not None:
        ball = SpherePrimitive(pose=_pose(hand.position, _LEVEL), size=_vector(np.full(3, 0.08)), color=_SKIN)
        arrow = _arrow(hand.position, hand.force * PER_NEWTON, _YELLOW)
        yield _scene("hands", WORLD, stamp, spheres=[ball], arrows=[arrow])
    tool = newest.get(STATE_EE.key)
    if (bag := world.bag) is not None and isinstance(tool, EndEffector):
        at = np.array([*tool.position[:2], bag.height])
        ball = SpherePrimitive(pose=_pose(at, _LEVEL), size=_vector(np.full(3, 0.15)), color=_WOOD)
        ends = [Point3(x=p[0], y=p[1], z=p[2]) for p in (tool.position, at)]
        rope = LinePrimitive(type=LinePrimitive.LINE_STRIP, thickness=0.004, points=ends, color=_WOOD)
        rope.pose.CopyFrom(_pose(np.zeros(3), _LEVEL))
        yield _scene("bag", BASE, stamp, spheres=[ball], lines=[rope])


_SHOWS: dict[str, Show] = {
    "state/base": _base,
    "state/ee": _tool,
    "sensor/ft": _sensor,
    "sensor/camera": _camera,
    "state/joints": _joints,
    "control/target": _target,
    "task/status": _marker,
    "wrench/external": _wrench,
    "control/status": _limits,
    "sim/world": _world,
}
_WORDS = (("state", "reason"), ("mode", "reason"), ("state", "detail"), ("state", ""))
"""Fields of a message that say how something is, and why."""
_GRAVE = {"braking": Log.WARNING, "stopped": Log.ERROR, "fault": Log.ERROR, "degraded": Log.WARNING}


def _logged(key: str, message: Record, before: Record | None, stamp: Timestamp) -> Iterator[Shown]:
    """A line for each change of a state or a reason; numbers in it change all the time and count for nothing."""
    words = next((names for names in _WORDS if all(hasattr(message, name) for name in names if name)), None)
    if words is None:
        return
    state, reason = (getattr(message, name) if name else "" for name in words)
    if before is not None:
        then, why = (getattr(before, name) if name else "" for name in words)
        if (then, _without_numbers(why)) == (state, _without_numbers(reason)):
            return
    text = f"{state}: {reason}" if reason else state
    yield Shown("/log", Log(timestamp=stamp, level=_GRAVE.get(state, Log.INFO), message=text, name=key))


def _without_numbers(text: str) -> str:
    return "".join(letter for letter in text if not (letter.isdigit() or letter in ".-"))


def _scene(name: str, frame: str, stamp: Timestamp, **shapes: Any) -> Shown:
    entity = SceneEntity(timestamp=stamp, frame_id=frame, id=name, **shapes)
    return Shown("/scene", SceneUpdate(entities=[entity]))


def _arrow(tail: Array, vector: Array, colour: Color) -> ArrowPrimitive:
    """From a point; Foxglove's arrows lie along x."""
    length = float(np.linalg.norm(vector))
    head = min(0.04, length / 2.0)
    turn = _along(vector / length) if length > 0.0 else _LEVEL
    shape = {"shaft_length": length - head, "shaft_diameter": 0.012, "head_length": head, "head_diameter": 0.03}
    return ArrowPrimitive(pose=_pose(tail, turn), **shape, color=colour)


def _along(direction: Array) -> Array:
    """A quaternion that turns x into a unit vector."""
    axis = np.cross((1.0, 0.0, 0.0), direction)
    sine, cosine = float(np.linalg.norm(axis)), float(direction[0])
    if sine < 1e-9:
        return _LEVEL if cosine > 0.0 else np.array((0.0, 0.0, 1.0, 0.0))
    return quaternion(rotation_from_vector(axis / sine * np.arctan2(sine, cosine)))


def _pose(position: Array, orientation: Array) -> Pose:
    return Pose(position=_vector(position), orientation=_quaternion(orientation))


def _vector(values: Array) -> Vector3:
    return Vector3(x=values[0], y=values[1], z=values[2])


def _quaternion(values: Array) -> Quaternion:
    return Quaternion(x=values[0], y=values[1], z=values[2], w=values[3])
