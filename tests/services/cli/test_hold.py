"""`tandem hold` says how far the tool has got, and what keeps it from the pose."""

from __future__ import annotations

import numpy as np
import pytest

from services.cli.hold import TELL, Way, held_back, make_target
from shared.messages import ControlStatus, EndEffector

ZERO3, ZERO6 = (0.0,) * 3, (0.0,) * 6
MARGIN = (5.0, 5.0, 0.04, 2.0, 2.0, 2.0)


def status(state: str = "tracking", reason: str = "", active: tuple[float, ...] = ZERO6) -> ControlStatus:
    return ControlStatus(state, reason, "certified", ZERO6, MARGIN, active, 0.0, 0.0, 0.0)


def tool(x: float) -> EndEffector:
    return EndEffector((x, -0.3, 1.0), (0.0, 0.0, 0.0, 1.0), ZERO3, ZERO3)


def test_the_way_is_told_now_and_then_and_the_arrival_once() -> None:
    way = Way(make_target([0.5, -0.3, 1.0, 0.0, 0.0, 0.0], [25.0] * 3, [10.0] * 3))
    assert way.told(0.0, tool(0.3), status(), "") == "200 mm and 0.0 degrees from the pose"
    assert way.told(0.9 * TELL, tool(0.4), status(), "") == ""
    assert way.told(TELL, tool(0.4), status(), "") == "100 mm and 0.0 degrees from the pose"
    assert way.told(TELL, tool(0.498), status(), "") == "there: 2 mm and 0.0 degrees from the pose"
    assert way.told(9.0 * TELL, tool(0.498), status(), "") == ""
    pushed = way.told(10.0 * TELL, tool(0.45), status("yielding", "", (0, 0, -1, 0, 0, 0)), "")
    assert pushed == "50 mm and 0.0 degrees from the pose, held back: force z at its limit (+0.04 N left)"


@pytest.mark.parametrize(
    ("said", "gate", "back"),
    [
        (status(), "", ""),
        (status(), "commands late: 5; base commands expired: 2", ""),
        (status("braking", "wrench/external is silent"), "", "wrench/external is silent"),
        (status("waiting"), "", "waiting"),
        (status(), "joint arm_4 at its end; commands late: 5", "joint arm_4 at its end"),
    ],
    ids=["nothing", "what was counted", "a fault", "a start", "a joint"],
)
def test_what_holds_it_back_is_what_holds_it_back_now(said: ControlStatus, gate: str, back: str) -> None:
    assert held_back(said, gate) == back


def test_an_angle_is_told_in_degrees() -> None:
    way = Way(make_target([0.5, -0.3, 1.0, 0.0, 0.0, np.pi / 2], [25.0] * 3, [10.0] * 3))
    assert way.told(0.0, tool(0.5), status(), "") == "0 mm and 90.0 degrees from the pose"
