"""What holds under a configuration: certified speeds, the excess while the environment moves, and their two forms."""

from __future__ import annotations

import numpy as np
import pytest

from services.controller.guarantee import as_map, as_words, certificates
from services.controller.parameters import ControllerParameters
from shared.spatial import rotation_from_vector

LIMIT = np.array((10.0, 10.0, 10.0, 0.5, 3.0, 3.0))
ERROR = np.array((0.3,) * 3 + (0.03,) * 3)


def panel(**changes: object) -> ControllerParameters:
    """A person on a panel."""
    declared = {"contact_stiffness": 500.0, "contact_reach": (1.05, 0.3, 0.05), "max_linear": 1.0}
    return ControllerParameters.of({**declared, "delay": 0.0, "lag": 0.0, **changes})


@pytest.mark.parametrize(
    ("period", "linear", "angular"),
    [(0.036, (0.172, 0.132, 0.081), (0.262, 0.077, 0.122)), (0.012, (0.515, 0.398, 0.243), (0.787, 0.232, 0.367))],
)
def test_published_speeds_of_a_person_on_a_panel(period: float, linear: tuple, angular: tuple) -> None:
    """Without delay, lag and reserve these are ``min_j W_j / (Kbar_ji T)``; a reach widened for turning lowers them."""
    parameters = panel(period=period, reserve=0.0, max_angular=0.3)
    found = np.array([one.speed for one in certificates(parameters, LIMIT, ERROR)])
    published = np.minimum(np.array(linear + angular), (1.0,) * 3 + (0.3,) * 3)
    assert np.all(found <= published * 1.01)
    assert np.all(found >= published * 0.65)


def test_delay_and_lag_count_like_the_period() -> None:
    fast = certificates(panel(period=0.06), LIMIT, ERROR)
    slow = certificates(panel(period=0.02, delay=0.02, lag=0.02), LIMIT, ERROR)
    assert [one.speed for one in slow[:3]] == pytest.approx([one.speed for one in fast[:3]], rel=0.15)


def test_excess_grows_with_the_environment_s_speed() -> None:
    slow, fast = (certificates(panel(), LIMIT, ERROR, speed) for speed in (0.1, 0.2))
    # Twice the speed, and twice as long to speed up to it.
    assert all(0 < 2 * one.excess < other.excess < 4 * one.excess for one, other in zip(slow, fast, strict=True))


def test_text_names_what_limits() -> None:
    told = as_words(panel(), LIMIT, ERROR)
    assert all(len(row) == len(told.head) for row in told.rows) and len(told.rows) == 6
    text = "\n".join((*told.before, *told.head, *(cell for row in told.rows for cell in row), *told.after))
    assert all(part in text for part in ("limit about x", "mm/s", "excess", "strict", "500 N/m", "1.05, 0.3, 0.05"))


def test_map_has_what_the_excess_follows_from() -> None:
    """The stiffness bound of a tool turned by 90 degrees about x is that of a reach with y and z exchanged."""
    zone = {"stiffness": 5000.0, "reach": (0.1, 0.05, 0.05)}
    found, turned = (
        as_map(
            panel(contact_reach=reach, yield_start=0.8, zones=[zone]), LIMIT, ERROR, 0.1, [rotation_from_vector(turn)]
        )
        for reach, turn in (((1.2, 0.3, 0.05), (0, 0, 0)), ((1.2, 0.05, 0.3), (np.pi / 2, 0, 0)))
    )
    assert found["form"].startswith("rounded") and len(found["axes"]) == 6
    moving = found["moving"]
    (stiffness,) = np.array(moving["stiffness"])
    assert stiffness == pytest.approx(np.array(turned["moving"]["stiffness"])[0], rel=1e-6)
    lasts = moving["response"] + 0.1 / (2.0 * min(moving["acceleration"][:3]))
    growth = np.linalg.norm(stiffness[:, :3], axis=1) * 0.1 * lasts
    assert moving["factor"] * growth == pytest.approx([axis["excess"] for axis in found["axes"]])
    assert all(axis["speed"] > 0 for axis in found["axes"])
