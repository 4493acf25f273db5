"""The onboard inverse kinematics reaches the whole carry from the start of the carrying scenario, without physics."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from services.sim.robot.arm import ARM_MARGIN, LOWEST_TOOL, TORSO_BOTTOM, TORSO_MARGIN, TORSO_WEIGHT
from services.sim.robot.kinematics import CARRY_HOME, HOME, arm_kinematics
from services.sim.robot.physics import FRICTION
from shared.robot.ik import DifferentialIK
from shared.robot.tiago import CHAIN
from shared.spatial import GRAVITY, pose_error, quaternion_from_rpy, rotation_from_vector, rotation_matrix

DT = 0.02
FLAT = -90.0
"""Roll [degrees] of the tool while the panel is flat; it turns to 0 with the panel."""
LEANING = ((0, 0), (15, 0), (-15, 0), (0, 15), (0, -15))
"""Pitch and yaw [degrees]."""


class Walk:
    """Tool poses in front of the robot, gone to from the start as the arm does, but without inertia and load."""

    def __init__(self) -> None:
        model = self.kinematics = arm_kinematics(CARRY_HOME)
        weight = np.array([TORSO_WEIGHT] + [1.0] * 7)
        margin = np.array([TORSO_MARGIN] + [ARM_MARGIN] * 7)
        self._ik = DifferentialIK(model.lower, model.upper, model.speed, margin, CHAIN, weight)
        self.start = model.tool()
        self._share = (model.home[0] - TORSO_BOTTOM) / (self.start[0][2] - LOWEST_TOOL)

    def to(self, position: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, bool]:
        """Joint positions (8,) after at most 12 s, and whether the pose is reached."""
        model, q = self.kinematics, self.kinematics.home.copy()
        for _ in range(round(12.0 / DT)):
            model.update(q)
            error = pose_error(*model.tool(), position, rotation)
            if np.linalg.norm(error[:3]) < 1e-3 and np.linalg.norm(error[3:]) < 4e-3:
                return q, True
            twist = -3.0 * error
            twist /= max(1.0, np.linalg.norm(twist[:3]) / 0.15, np.linalg.norm(twist[3:]) / 0.5)
            reference, lead = model.home.copy(), np.zeros(8)
            torso = TORSO_BOTTOM + self._share * (model.tool_position()[2] - LOWEST_TOOL)
            reference[0] = min(max(torso, TORSO_BOTTOM), model.home[0])
            lead[0] = self._share * twist[2] if reference[0] == torso else 0.0
            q = q + self._ik.solve(q, model.jacobian(), twist, reference, lead).velocity * DT
        return q, False


@pytest.fixture(scope="module")
def walk() -> Walk:
    return Walk()


def attitude(turned: float, pitch: float, yaw: float) -> np.ndarray:
    """Rotation of the tool with the panel turned, pitched and yawed by so many degrees."""
    leaning = rotation_matrix(quaternion_from_rpy(0.0, np.radians(pitch), np.radians(yaw)))
    return leaning @ rotation_from_vector((np.radians(FLAT + turned), 0.0, 0.0))


def test_the_start_is_in_front_of_the_panel(walk: Walk) -> None:
    position, rotation = walk.start
    assert position == pytest.approx((0.45, -0.39, 0.78), abs=2e-3)
    assert rotation == pytest.approx(attitude(0.0, 0.0, 0.0), abs=5e-3)


@pytest.mark.parametrize("turned", [0.0, 45.0, 90.0])
def test_every_pose_of_the_carry_is_reached(walk: Walk, turned: float) -> None:
    missed = []
    for x, z, (pitch, yaw) in product((0.45, 0.52, 0.6), (0.3, 0.55, 0.8, 1.05), LEANING):
        if (pitch or yaw) and x != 0.52:
            continue
        if not walk.to(np.array((x, walk.start[0][1], z)), attitude(turned, pitch, yaw))[1]:
            missed.append((x, z, pitch, yaw))
    assert missed == []


def test_the_arm_carries_half_the_panel_at_the_start_and_upright(walk: Walk) -> None:
    model = walk.kinematics
    weight = np.array((0.0, 0.0, -0.5 * 1.5 * GRAVITY))
    for turned, z in ((0.0, 0.78), (90.0, 0.9), (90.0, 0.3)):
        q, reached = walk.to(np.array((0.54, walk.start[0][1], z)), attitude(turned, 0.0, 0.0))
        assert reached
        assert (np.abs(model.holding_effort(q, weight)) < model.effort).all()


@pytest.mark.parametrize(
    ("direction", "motors", "with_friction", "weakest"),
    [
        ((0, 0, -1), 31.6, 37.3, "arm_right_6_joint"),
        ((0, 0, 1), 43.0, 48.7, "arm_right_6_joint"),
        ((0, 1, 0), 16.6, 23.1, "arm_right_5_joint"),
        ((0, -1, 0), 22.1, 28.6, "arm_right_5_joint"),
        ((1, 0, 0), 76.6, 80.4, "arm_right_4_joint"),
        ((-1, 0, 0), 121.0, 124.8, "arm_right_4_joint"),
    ],
    ids=["down", "up", "left", "right", "forwards", "backwards"],
)
def test_what_the_arm_holds_where_the_load_is_held(
    direction: tuple[int, ...], motors: float, with_friction: float, weakest: str
) -> None:
    """The table of docs/simulation.md."""
    model = arm_kinematics(HOME)
    alone = model.holding_effort(model.home, np.zeros(3))
    per_newton = model.holding_effort(model.home, np.array(direction, dtype=float)) - alone
    loaded = np.abs(per_newton) > 1e-9
    for friction, wanted in ((0.0 * FRICTION, motors), (FRICTION, with_friction)):
        room = np.sign(per_newton) * (model.effort + friction) - alone
        most = np.divide(room, per_newton, out=np.full(len(CHAIN), np.inf), where=loaded)
        assert most.min() == pytest.approx(wanted, abs=0.1)
        assert CHAIN[int(most.argmin())] == weakest
