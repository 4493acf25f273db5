"""What the wrist sensor has to read, worked out from the URDF's masses."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from services.sim.robot.kinematics import full_model, home
from shared.robot.kinematics import joint_names
from shared.robot.tiago import CHAIN, SENSOR_FRAME, TOOL_FRAME
from shared.spatial import GRAVITY


def statics(position: np.ndarray, force: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Wrench (6,) on the sensor in its axes: weight of everything beyond it, plus a force and torque at the tool."""
    model = full_model()
    data = model.createData()
    q = home(model)
    for name, value in zip(CHAIN, position, strict=True):
        q[joint_names(model).index(name)] = value
    pin.framesForwardKinematics(model, data, q)
    sensor, tool = (data.oMf[model.getFrameId(name)] for name in (SENSOR_FRAME, TOOL_FRAME))
    forces = [(force, tool.translation)]
    for name, centre, mass in (
        ("gripper_right_link", (-0.000294, 0.000291, -0.033086), 0.60266),
        ("gripper_right_left_finger_link", (-0.00447, 0.010766, -0.121013), 0.10998),
        ("gripper_right_right_finger_link", (0.00447, -0.010766, -0.121013), 0.10998),
    ):
        pose = data.oMf[model.getFrameId(name)]
        forces.append((np.array((0, 0, -mass * GRAVITY)), pose.act(np.array(centre))))
    total = sum(f for f, _ in forces)
    about = torque + sum(np.cross(point - sensor.translation, f) for f, point in forces)
    return np.concatenate((sensor.rotation.T @ total, sensor.rotation.T @ about))


def reads(reading: np.ndarray, wanted: np.ndarray) -> bool:
    """Whether two wrenches (6,) agree within 1 % of the force and 2 % of the torque.

    Torque is judged against the lever arm of the whole load at least, so that a vanishing one has a scale too.
    """
    force, torque = np.linalg.norm(wanted[:3]), np.linalg.norm(wanted[3:])
    off = np.linalg.norm((reading - wanted)[:3]), np.linalg.norm((reading - wanted)[3:])
    return bool(off[0] < 0.01 * force and off[1] < 0.02 * max(torque, 0.1 * force))
