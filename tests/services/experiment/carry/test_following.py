"""How far and how late the robot follows is held against what the person wants, not against the panel's other end."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from services.experiment.carry.carry_protocol import Guidance
from services.experiment.carry.following import Followed, followed
from tests.services.experiment.carry.motions import along, motion

TIME = np.arange(0.0, 8.0, 1 / 30)
PULL, TURN = Guidance("pull", "along", 0.5), Guidance("turn", "roll", 1.0)


def ramp(start: float, amount: float) -> np.ndarray:
    """From nothing to an amount within 4 s, from a time [s] on."""
    return amount * np.clip((TIME - start) / 4.0, 0.0, 1.0)


def rolled(way: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(along(way)).as_matrix()


def pulled(panel: np.ndarray, base: np.ndarray, wish: np.ndarray) -> Followed:
    """A rigid panel pulled along x: far end and tool go one way (n,) [m], the base another, and the wish a third."""
    ways = {"hand": along(panel), "tool": along(panel), "base": along(base), "wish": along(wish)}
    (found,) = followed(motion(TIME, **ways, push=500.0 * along(wish - panel)), (PULL,))
    return found


def test_both_ends_of_a_rigid_panel_that_is_held_back_fall_short_of_the_wish() -> None:
    found = pulled(ramp(1.2, 0.4), ramp(1.5, 0.3), ramp(1.0, 0.5))
    assert (found.far, found.near, found.base) == pytest.approx((0.8, 0.8, 0.6), abs=0.01)
    assert found.short(found.base) == pytest.approx(0.2, abs=5e-3)


def test_lags_are_behind_the_wish() -> None:
    found = pulled(ramp(1.2, 0.5), ramp(1.7, 0.5), ramp(1.0, 0.5))
    assert (found.lag, found.base_lag) == pytest.approx((0.2, 0.7), abs=0.04)
    assert (found.start, found.end) == pytest.approx((1.0, 5.0), abs=0.15)


def test_what_never_moves_never_keeps_up_and_a_wish_alone_is_a_movement() -> None:
    found = pulled(0.0 * TIME, 0.0 * TIME, ramp(1.0, 0.5))
    assert (found.far, found.near, found.base) == (0.0, 0.0, 0.0)
    assert found.lag == found.base_lag == found.reaction == np.inf


def test_a_turn_is_that_of_the_panel_at_the_far_end_and_of_the_tool_at_the_other() -> None:
    turned = motion(
        TIME,
        doing=np.full(len(TIME), "turn"),
        wish_axes=rolled(ramp(1.0, 1.0)),
        panel_axes=rolled(ramp(1.1, 0.9)),
        tool_axes=rolled(ramp(1.4, 0.7)),
    )
    (found,) = followed(turned, (TURN,))
    assert (found.far, found.near, found.lag) == pytest.approx((0.9, 0.7, 0.4), abs=0.04)
    assert np.isnan([found.base, found.base_lag, found.reaction]).all()


def test_a_movement_that_the_person_did_not_want_is_none_of_the_script() -> None:
    (found,) = followed(motion(TIME), (PULL,))
    assert np.isnan(found.start) and found.near == 0.0
