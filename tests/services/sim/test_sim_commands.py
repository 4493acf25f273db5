"""What can be asked of the simulation, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shared import topics
from shared.parameters import Refused
from tests.services.sim.rig import Rig


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_a_bag_is_hung_made_heavier_and_taken_off(rig: Rig) -> None:
    weightless = rig.last(topics.SENSOR_FT)
    assert rig.last(topics.SIM_WORLD).bag is None
    for mass in (2.04, 2.85):
        assert rig.ask(command="load", mass=mass) == {"ok": True}
        rig.run(1.5)
        world = rig.last(topics.SIM_WORLD)
        assert world.bag.mass == mass
        assert world.bag.height == pytest.approx(0.39, abs=0.02)
        assert world.contact_force == pytest.approx((0, 0, -mass * 9.81), abs=0.1)
        added = rig.last(topics.SENSOR_FT).force - weightless.force
        assert np.linalg.norm(added) == pytest.approx(mass * 9.81, abs=1.0)
    rig.ask(command="load", mass=0)
    rig.run(1.0)
    assert rig.last(topics.SIM_WORLD).bag is None


def test_pushes_add_up_and_the_wrist_feels_them(rig: Rig) -> None:
    before = rig.last(topics.SENSOR_FT)
    for _ in range(2):
        rig.ask(command="push", force=[3.0, 0.0, 0.0], duration=1.0)
    rig.run(0.2)
    assert rig.last(topics.SIM_WORLD).contact_force == pytest.approx((6, 0, 0))
    assert np.linalg.norm(rig.last(topics.SENSOR_FT).force - before.force) == pytest.approx(6.0, abs=1.0)


def test_reset_takes_bag_pushes_and_faults_away_and_the_arm_home(rig: Rig) -> None:
    start = rig.last(topics.STATE_EE).position
    rig.ask(command="load", mass=2.0)
    rig.ask(command="push", force=[5.0, 0.0, 0.0], duration=100.0)
    rig.ask(command="fault", target="ft", kind="off")
    rig.move((0, 0, -0.1), 0.5)
    rig.run(0.1)
    rig.ask(command="reset")
    silent = len(rig.received["sensor/ft"])
    rig.run(0.3)
    assert rig.last(topics.STATE_EE).position == pytest.approx(start, abs=1e-4)
    assert rig.last(topics.SIM_WORLD).bag is None
    assert rig.last(topics.SIM_WORLD).contact_force == pytest.approx((0, 0, 0))
    assert len(rig.received["sensor/ft"]) > silent


@pytest.mark.parametrize(
    ("request_", "says"),
    [
        ({}, "command is missing, wanted one of reset, load, push, hand, cover_marker, fault"),
        ({"command": "dance"}, "'dance', wanted one of reset, load, push, hand, cover_marker, fault"),
        ({"command": ["load"]}, "wanted text"),
        ({"command": "hand", "script": "carry"}, "no panel"),
        ({"command": "cover_marker"}, "no panel"),
        ({"command": "load"}, "mass is missing"),
        ({"command": "load", "mass": -1}, "mass is -1, wanted 0 to 20 kg"),
        ({"command": "load", "mass": 0.01}, "0.05 to 20 kg"),
        ({"command": "load", "mass": float("nan")}, "mass is nan"),
        ({"command": "load", "mass": True}, "mass is True"),
        ({"command": "push", "force": [1, 2], "duration": 1}, "force has 2 elements, wanted 3"),
        ({"command": "push", "force": [1, 2, 1e9], "duration": 1}, "every element -300 to 300 N"),
        ({"command": "push", "torque": "much", "duration": 1}, "torque is 'much'"),
        ({"command": "push", "force": [1, 2, 3]}, "duration is missing"),
        ({"command": "fault", "target": "camera", "kind": "off"}, "no panel"),
        ({"command": "fault", "target": "camera", "kind": "bias", "value": 1}, "no panel"),
        ({"command": "fault", "target": "wheels", "kind": "off"}, "wanted one of ft, camera, joints"),
        ({"command": "fault", "target": "ft", "kind": "sad"}, "off, stuck, garbage, bias, delay, ok"),
        ({"command": "fault", "target": "ft", "kind": "delay", "value": -1}, "value is -1"),
        ({"command": "fault", "target": "ft", "kind": "bias", "value": [1, 2]}, "value has 2 elements, wanted 6"),
        ({"command": "fault", "target": "ft", "kind": "bias"}, "value"),
    ],
)
def test_refusals_are_one_line_and_change_nothing(rig: Rig, request_: dict[str, Any], says: str) -> None:
    with pytest.raises(Refused) as refusal:
        rig.ask(**request_)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)
    before = len(rig.received["sensor/ft"])
    rig.run(0.1)
    assert len(rig.received["sensor/ft"]) == before + 10
    assert rig.last(topics.SIM_WORLD).bag is None
