"""What the certificate states, and on what it depends."""

from __future__ import annotations

import numpy as np
import pytest

from services.controller.guarantee import as_map, certificates
from services.controller.parameters import ControllerParameters
from shared.spatial import rotation_from_vector

LIMIT = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))
ERROR = np.array((0.3,) * 3 + (0.03,) * 3)
PANEL = {
    "contact_stiffness": 500.0,
    "contact_reach": (1.05, 0.3, 0.05),
    "delay": 0.0,
    "lag": 0.0,
    "max_linear": 1.0,
}


@pytest.mark.parametrize(
    ("period", "linear", "angular"),
    [
        (0.036, (0.172, 0.132, 0.081), (0.262, 0.077, 0.122)),
        (0.012, (0.515, 0.398, 0.243), (0.787, 0.232, 0.367)),
    ],
)
def test_published_speeds_of_a_person_on_a_panel(period: float, linear: tuple, angular: tuple) -> None:
    """Without delay, lag and reserve these are ``min_j W_j / (Kbar_ji T)``; a reach widened for turning lowers them."""
    parameters = ControllerParameters.of({**PANEL, "period": period, "reserve": 0.0, "max_angular": 0.3})
    found = [one.speed for one in certificates(parameters, LIMIT, ERROR)]
    published = np.minimum(np.array(linear + angular), (1.0,) * 3 + (0.3,) * 3)
    assert np.all(np.array(found) <= published * 1.01)
    assert np.all(np.array(found) >= published * 0.65)


def test_delay_and_lag_count_like_the_period() -> None:
    fast = certificates(ControllerParameters.of({**PANEL, "period": 0.06}), LIMIT, ERROR)
    slow = certificates(
        ControllerParameters.of({**PANEL, "period": 0.02, "delay": 0.02, "lag": 0.02}), LIMIT, ERROR
    )
    assert [one.speed for one in slow[:3]] == pytest.approx([one.speed for one in fast[:3]], rel=0.15)


def test_excess_grows_with_the_environment_s_speed() -> None:
    parameters = ControllerParameters.of(PANEL)
    slow, fast = (certificates(parameters, LIMIT, ERROR, speed) for speed in (0.1, 0.2))
    # Twice the speed, and twice as long to speed up to it.
    assert all(2 * one.excess < other.excess < 4 * one.excess for one, other in zip(slow, fast, strict=True))
    assert all(one.excess > 0 for one in slow)


def test_what_the_excess_follows_from_is_stated_for_programs() -> None:
    """The stiffness bound of a tool turned by 90 degrees about x is that of a reach with y and z exchanged."""
    first, second = (
        as_map(
            ControllerParameters.of({"contact_reach": reach, "yield_start": 0.8}),
            LIMIT,
            ERROR,
            0.1,
            [rotation],
        )
        for reach, rotation in (
            ((1.2, 0.05, 0.3), rotation_from_vector((np.pi / 2, 0.0, 0.0))),
            ((1.2, 0.3, 0.05), np.eye(3)),
        )
    )
    moving, speed = second["moving"], second["environment_speed"]
    stiffness = np.array(moving["stiffness"])
    assert np.array(first["moving"]["stiffness"]) == pytest.approx(stiffness, rel=1e-6)
    assert stiffness.shape == (1, 6, 6)
    lasts = moving["response"] + speed / (2.0 * min(moving["acceleration"][:3]))
    growth = np.linalg.norm(stiffness[0][:, :3], axis=1) * speed * lasts
    assert moving["factor"] * growth == pytest.approx([axis["excess"] for axis in second["axes"]])
