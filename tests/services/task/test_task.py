"""The service in one process under simulated time: a whole carry with real images, and what it publishes when."""

from __future__ import annotations

import numpy as np
import pytest

from shared.parameters import Refused
from shared.topics import (
    BASE_ENABLE,
    COMMAND_GRIPPER,
    COMMAND_HEAD,
    CONTROL_TARGET,
    STATE_EE,
    STATE_GRIPPER,
    TASK_STATUS,
)
from tests.services.task.rig import Rig


def test_a_whole_carry_with_images() -> None:
    rig = Rig().begun().until("done", 120.0)
    received = rig.robot.received
    states = list(dict.fromkeys(r.message.state for r in received[TASK_STATUS.key]))
    assert states == [
        *("idle", "calibrating", "searching", "approaching", "grasping", "carrying"),
        *("releasing", "retreating", "done"),
    ]
    assert all(r.header.valid for r in received[TASK_STATUS.key][10:])
    assert not rig.robot.toy.gripped
    assert rig.robot.last(TASK_STATUS).rotation == pytest.approx(np.pi / 2, abs=0.3)
    # Where it was grasped is where the panel really is.
    home = rig.task.machine._carry.home
    assert home.near(rig.robot.toy.grasp, 0.015, 0.06)


def test_limits_are_the_paper_s_and_the_nominal_wrench_is_half_the_weight() -> None:
    rig = Rig().carrying()
    message = rig.robot.last(CONTROL_TARGET)
    assert message.force_limit.tolist() == [10.0, 10.0, 10.0]
    assert message.torque_limit.tolist() == [0.5, 3.0, 3.0]
    assert message.nominal_force.tolist() == pytest.approx([0.0, 0.0, -1.5 * 9.81 / 2])
    assert not message.nominal_torque.any()


def test_rates_while_carrying() -> None:
    rig = Rig().carrying()
    for received in rig.robot.received.values():
        received.clear()
    rig.run(5.0)
    assert len(rig.robot.received[CONTROL_TARGET.key]) >= 25
    assert len(rig.robot.received[BASE_ENABLE.key]) >= 25
    assert len(rig.robot.received[TASK_STATUS.key]) >= 25
    closing = rig.robot.received[COMMAND_GRIPPER.key]
    assert 10 <= len(closing) <= 13 and all(r.message.opening == 0.0 for r in closing)
    assert not rig.robot.received[COMMAND_HEAD.key]


def test_at_rest_the_arm_is_left_to_others() -> None:
    rig = Rig().run(3.0)
    assert rig.robot.state == "idle"
    assert not rig.robot.received[CONTROL_TARGET.key] and not rig.robot.received[COMMAND_GRIPPER.key]
    assert not any(r.message.enabled for r in rig.robot.received[BASE_ENABLE.key])


def test_it_asks_for_a_tare() -> None:
    rig = Rig()
    rig.robot.compensation = "none"
    rig.begun().until("calibrating").run(3.0)
    assert rig.robot.state == "calibrating" and "tandem tare" in rig.robot.reason
    rig.robot.compensation = "tare"
    rig.until("carrying")


def test_a_tare_is_not_enough_if_payload_is_wanted() -> None:
    rig = Rig(compensation="payload")
    rig.robot.compensation = "tare"
    rig.begun().until("calibrating").run(3.0)
    assert "tandem identify" in rig.robot.reason


MISSING: dict[str, tuple[str, str]] = {
    STATE_GRIPPER.key: ("idle", "state/gripper"),
    STATE_EE.key: ("idle", "state/ee"),
}


@pytest.mark.parametrize("key", MISSING)
def test_says_what_it_waits_for_at_the_start(key: str) -> None:
    rig = Rig()
    rig.robot.muted = {key}
    rig.run(1.0)
    state, words = MISSING[key]
    assert rig.robot.state == state and words in rig.robot.reason
    with pytest.raises(Refused, match="not yet"):
        rig.ask("start")
    rig.robot.muted = set()
    rig.run(1.0)
    assert "ready" in rig.robot.reason
    rig.ask("start")
