"""What motion allows beyond a limit follows from the guarantee."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from services.experiment.carry.allowance import Certified


def test_what_motion_allows_is_what_certify_states() -> None:
    settings = {"yield_start": 0.8, "contact_stiffness": 500.0, "contact_reach": [1.2, 0.05, 0.3]}
    limit, error = (10.0, 10.0, 10.0, 0.5, 3.0, 3.0), (0.6, 0.6, 0.6, 0.03, 0.1, 0.1)
    quarter = Rotation.from_rotvec([(0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.0)]).as_quat()
    found = Certified.of(settings, np.array(limit), np.array(error), quarter)
    assert found.stiffness.shape == (2, 6, 6)
    # Turned by 90 degrees, y and z change places.
    swap = np.array((0, 2, 1, 3, 5, 4))
    assert found.stiffness[1] == pytest.approx(found.stiffness[0][np.ix_(swap, swap)])
    speed = 0.1
    twist = np.array([(speed, 0.0, 0.0, 0.0, 0.0, 0.0)])
    expected = 3.0 * found.stiffness[0][:, 0] * speed * (found.response + speed / (2 * 2.0))
    assert found.excess(twist, np.array([0]))[0] == pytest.approx(expected)
    assert np.all(found.excess(2 * twist, np.array([0])) > 2 * found.excess(twist, np.array([0])))


def test_a_configuration_without_a_certificate_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="yield_start"):
        Certified.of({"yield_start": 7.0}, np.full(6, 10.0), np.full(6, 0.1), np.zeros((0, 4)))
