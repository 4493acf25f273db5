"""The person that is drawn: it reaches the panel with limbs of their length, wherever the panel is."""

from __future__ import annotations

import numpy as np
import pytest

from services.viewer.draw.person import FOREARM, SHIN, THIGH, UPPER_ARM, posture

LEGS, SHINS, ARMS, FOREARMS = slice(0, 2), slice(2, 4), slice(8, 10), slice(10, 12)


@pytest.mark.parametrize("height", [0.3, 0.6, 0.95])
@pytest.mark.parametrize("across", [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0)], ids=["flat", "upright"])
def test_it_reaches_the_panel_with_limbs_of_their_length(height: float, across: tuple[float, ...]) -> None:
    edge = np.array((1.7, -0.4, height))
    limbs = posture(edge, np.array(across), np.array((1.0, 0.0, 0.0)), holds=True)
    lengths = np.linalg.norm(limbs[:, 1] - limbs[:, 0], axis=1)
    for part, length in ((LEGS, THIGH), (SHINS, SHIN), (ARMS, UPPER_ARM), (FOREARMS, FOREARM)):
        assert lengths[part] == pytest.approx(length, abs=0.1)
    assert limbs[FOREARMS, 1].mean(axis=0) == pytest.approx(edge)
    assert limbs[SHINS, 1, 2] == pytest.approx(0.08)


def test_its_arms_hang_when_it_does_not_hold_the_panel() -> None:
    limbs = posture(np.array((1.7, 0.0, 0.8)), np.array((0.0, 1.0, 0.0)), np.array((1.0, 0.0, 0.0)), holds=False)
    assert (limbs[FOREARMS, 1, 2] < limbs[ARMS, 0, 2] - 0.4).all()
