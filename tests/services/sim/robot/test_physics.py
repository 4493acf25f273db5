"""What the wrist sensor reads while weights hang still, against statics worked out from the URDF's masses."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from services.sim.robot.kinematics import arm_kinematics
from services.sim.robot.physics import Physics
from shared.robot.kinematics import Kinematics
from shared.spatial import GRAVITY
from tests.services.sim.statics import reads, statics

STEP = 0.002
POSES = {
    "home": arm_kinematics().home,
    "stretched": np.array((0.2, 0.3, 0.4, 0.5, 0.6, 0.2, 0.3, -0.4)),
    "gripper up": np.array((0.1, 1.0, 0.2, 1.5, 1.8, -1.0, 1.2, 0.5)),
    "rolled": np.array((0.3, 0.6, 1.0, 1.0, 2.2, 1.5, 1.0, 1.9)),
    "twisted": np.array((0.0, 1.3, -0.5, 2.5, 0.8, 1.9, -1.2, -1.5)),
}


@pytest.mark.parametrize(("pose", "mass"), list(product(POSES, (0.0, 0.5, 2.0, 2.85))), ids=str)
def test_hanging_masses(pose: str, mass: float) -> None:
    force = np.array((0.0, 0.0, -mass * GRAVITY))
    reading, wanted = _settled(POSES[pose], force, np.zeros(3))
    assert reads(reading, wanted), (reading, wanted)


def test_pushes_in_every_direction() -> None:
    for force, torque in (((9, -4, 6), (0, 0, 0)), ((0, 0, 0), (0.8, -0.6, 0.4)), ((-5, 8, -3), (-1, 0.5, 1))):
        reading, wanted = _settled(POSES["home"], np.array(force, float), np.array(torque, float))
        assert reading == pytest.approx(wanted, abs=0.02 * np.linalg.norm(wanted[:3]))


def test_motors_give_what_statics_ask_for() -> None:
    kinematics = arm_kinematics()
    force = np.array((0.0, 0.0, -20.0))
    physics = Physics(kinematics.home, kinematics.effort, STEP)
    _hold(physics, kinematics, force, np.zeros(3))
    wanted = kinematics.holding_effort(physics.position, force)
    physics.close()
    assert physics.effort() == pytest.approx(wanted, abs=0.01 * 43)
    assert physics.effort()[1:] == pytest.approx(wanted[1:], abs=0.02)


def _settled(pose: np.ndarray, force: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reading (6,) with motors of unlimited effort in a pose, and the statics of where the arm came to rest."""
    kinematics = arm_kinematics()
    assert ((pose >= kinematics.lower) & (pose <= kinematics.upper)).all(), "the pose is outside the joints' limits"
    physics = Physics(pose, np.full(8, 1e4), STEP)
    _hold(physics, kinematics, force, torque)
    reading = physics.wrist_wrench()
    physics.close()
    return reading, statics(physics.position, force, torque)


def _hold(physics: Physics, kinematics: Kinematics, force: np.ndarray, torque: np.ndarray) -> None:
    for _ in range(250):
        kinematics.update(physics.position)
        physics.push(force.tolist(), torque.tolist(), kinematics.tool()[0].tolist())
        physics.step()
