"""What a carry costs the person."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from services.experiment.carry.effort import effort
from tests.services.experiment.carry.motions import along, guided

TIME = np.arange(0.0, 4.0, 1 / 30)


def test_work_is_force_times_way_and_torque_times_angle() -> None:
    axes = Rotation.from_rotvec(np.outer(0.1 * TIME, (0.0, 0.0, 1.0)))
    hand = np.array((1.7, -0.4, 0.9)) + along(0.2 * TIME)
    found = effort(guided(TIME, 0.0 * along(TIME), hand, axes, np.array((0.5, -0.4, 0.9))), -1.0, 9.0)
    lasts = TIME[-1] + 1 / 30
    assert found.work == pytest.approx((2.0 * 0.2 + 3.0 * 0.1) * lasts, rel=1e-2)
    assert found.lifting == pytest.approx(0.0, abs=1e-9)
    assert found.guiding == pytest.approx(found.work, rel=1e-9)
    assert (found.force, found.torque) == (2.0, 3.0)
