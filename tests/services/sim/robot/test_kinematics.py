"""The robot's own file against the published chain, its mass, and a second program that reads it."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pybullet
import pytest

from services.sim.robot.kinematics import HOME, arm_kinematics, full_model, home
from shared.robot.kinematics import joint_names
from shared.robot.tiago import CHAIN, JOINTS, TOOL_FRAME, URDF


@pytest.fixture(scope="module")
def model() -> pin.Model:
    return full_model()


def test_the_model_has_the_limits_of_the_description(model: pin.Model) -> None:
    limits = (model.lowerPositionLimit, model.upperPositionLimit, model.velocityLimit, model.effortLimit)
    rows = zip(*(limit.tolist() for limit in limits), strict=True)
    assert dict(zip(joint_names(model), rows, strict=True)) == JOINTS


def test_the_tool_starts_at_the_pose_of_the_experiment_and_the_sensor_behind_it() -> None:
    kinematics = arm_kinematics()
    position, rotation = kinematics.tool()
    assert position == pytest.approx((0.5, -0.3, 1.0), abs=1e-6)
    assert rotation == pytest.approx(np.eye(3), abs=1e-6)
    # 12.725 mm to the sensor's far side, 10 mm to the gripper, 120 mm to the grasping frame.
    assert kinematics.tool_in_sensor == pytest.approx((0, 0, 0.142725), abs=1e-6)
    sensor, axes = kinematics.sensor()
    assert sensor + axes @ kinematics.tool_in_sensor == pytest.approx(position, abs=1e-9)


def test_stretched_out_the_right_tool_is_where_the_published_chain_puts_it(model: pin.Model) -> None:
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    tool = data.oMf[model.getFrameId(TOOL_FRAME)]
    assert tool.translation == pytest.approx((-0.05744, -1.13507, 0.6865), abs=1e-4)
    left = data.oMf[model.getFrameId("gripper_left_grasping_frame")]
    assert left.translation == pytest.approx((-0.05744, 1.13507, 0.6865), abs=4e-3)


def test_what_hangs_on_the_sensor_weighs_0_8226_kg(model: pin.Model) -> None:
    beyond = ("gripper_right_link", "gripper_right_left_finger_link", "gripper_right_right_finger_link")
    mass = 0.0
    for link in ET.parse(URDF).getroot().iter("link"):
        if link.attrib["name"] in beyond:
            element = link.find("inertial/mass")
            assert element is not None
            mass += float(element.attrib["value"])
    assert mass == pytest.approx(0.8226, abs=1e-4)


def test_every_inertia_is_possible_and_every_start_position_allowed(model: pin.Model) -> None:
    for inertia in model.inertias[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        assert moments[0] > 0 and moments[2] < moments[0] + moments[1]
    start = home(model)
    assert (start >= model.lowerPositionLimit).all() and (start <= model.upperPositionLimit).all()
    assert set(HOME) <= set(joint_names(model))


def test_pybullet_and_pinocchio_agree_on_every_frame(model: pin.Model) -> None:
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(URDF), useFixedBase=True, physicsClientId=client)
        joints = [pybullet.getJointInfo(body, i, physicsClientId=client) for i in range(_count(body, client))]
        index = {info[1].decode(): info[0] for info in joints}
        rng = np.random.default_rng(1)
        data = model.createData()
        for _ in range(5):
            q = rng.uniform(model.lowerPositionLimit, model.upperPositionLimit)
            for name, value in zip(joint_names(model), q, strict=True):
                pybullet.resetJointState(body, index[name], value, physicsClientId=client)
            pin.framesForwardKinematics(model, data, q)
            for info in joints:
                state = pybullet.getLinkState(body, info[0], computeForwardKinematics=True, physicsClientId=client)
                pose = data.oMf[model.getFrameId(info[12].decode())]
                assert state[4] == pytest.approx(pose.translation, abs=1e-5), info[12]
                dot = abs(float(np.dot(state[5], pin.Quaternion(pose.rotation).coeffs())))
                assert math.acos(min(1.0, dot)) < 1e-3, info[12]
    finally:
        pybullet.disconnect(client)


def _count(body: int, client: int) -> int:
    return int(pybullet.getNumJoints(body, physicsClientId=client))


def test_jacobian_is_the_derivative_of_the_pose() -> None:
    kinematics = arm_kinematics()
    q = kinematics.home
    kinematics.update(q)
    position, rotation = kinematics.tool()
    jacobian = kinematics.jacobian()
    for column in range(len(CHAIN)):
        moved = q.copy()
        moved[column] += 1e-6
        kinematics.update(moved)
        near, turned = kinematics.tool()
        assert (near - position) / 1e-6 == pytest.approx(jacobian[:3, column], abs=1e-4)
        spin = (turned @ rotation.T - np.eye(3)) / 1e-6
        assert (spin[2, 1], spin[0, 2], spin[1, 0]) == pytest.approx(jacobian[3:, column], abs=1e-4)


@pytest.mark.parametrize("weight", [20.0, 28.0])
def test_the_start_configuration_carries_the_bags_within_every_effort_limit(weight: float) -> None:
    kinematics = arm_kinematics()
    effort = kinematics.holding_effort(kinematics.home, np.array((0.0, 0.0, -weight)))
    assert (np.abs(effort) < 0.95 * kinematics.effort).all()
