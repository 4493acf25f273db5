"""The description of the UR5e against the published parameters that it was written from."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from shared.robot.kinematics import full_model
from shared.robot.profile import Profile

PROFILE = Profile.load("ur5e-ros2")
DH = (  # a [m], d [m], alpha [rad]
    (0.0, 0.1625, np.pi / 2),
    (-0.425, 0.0, 0.0),
    (-0.3922, 0.0, 0.0),
    (0.0, 0.1333, np.pi / 2),
    (0.0, 0.0997, -np.pi / 2),
    (0.0, 0.0996, 0.0),
)
CENTRES = (  # mass [kg], centre of mass [m] in the frame of Denavit and Hartenberg
    (3.761, (0.0, -0.02561, 0.00193)),
    (8.058, (0.2125, 0.0, 0.11336)),
    (2.846, (0.15, 0.0, 0.0265)),
    (1.37, (0.0, -0.0018, 0.01634)),
    (1.3, (0.0, 0.0018, 0.01634)),
    (0.365, (0.0, 0.0, -0.001159)),
)
BASE = np.diag((-1.0, -1.0, 1.0, 1.0))  # the controller's frame in ROS' base_link: half a turn about z


def frames(position: np.ndarray) -> list[np.ndarray]:
    """Homogeneous transforms (4, 4) of the links in base_link."""
    pose, found = BASE, []
    for angle, (a, d, alpha) in zip(position, DH, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        step = ((c, -s * ca, s * sa, a * c), (s, c * ca, -c * sa, a * s), (0.0, sa, ca, d), (0.0, 0.0, 0.0, 1.0))
        pose = pose @ np.array(step)
        found.append(pose)
    return found


@pytest.mark.parametrize("seed", range(5))
def test_flange_and_centres_of_mass_are_where_the_published_parameters_put_them(seed: int) -> None:
    model = full_model(PROFILE.urdf)
    data = model.createData()
    position = np.random.default_rng(seed).uniform(-3.0, 3.0, 6)
    pin.framesForwardKinematics(model, data, position)
    expected = frames(position)
    flange = data.oMf[model.getFrameId(PROFILE.frames.sensor)]
    assert flange.homogeneous == pytest.approx(expected[-1], abs=1e-9)
    for joint, (frame, (mass, centre)) in enumerate(zip(expected, CENTRES, strict=True), start=1):
        inertia = model.inertias[joint]
        assert inertia.mass == pytest.approx(mass)
        assert data.oMi[joint].act(inertia.lever) == pytest.approx((frame @ (*centre, 1.0))[:3], abs=1e-4)


def test_every_inertia_is_possible() -> None:
    for inertia in full_model(PROFILE.urdf).inertias[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        assert moments[0] > 0 and moments[2] < moments[0] + moments[1]


def test_the_tools_x_axis_points_away_from_the_flange() -> None:
    model = full_model(PROFILE.urdf)
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array((0.0, -1.57, 1.57, 0.0, 1.57, 0.0)))
    flange, tool = (data.oMf[model.getFrameId(name)] for name in ("tool0", "tool"))
    assert tool.translation - flange.translation == pytest.approx(0.15 * tool.rotation[:, 0], abs=1e-9)
