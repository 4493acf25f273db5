"""The service in one process under simulated time: a whole carry with real images, and what it publishes when."""

from __future__ import annotations

import numpy as np
import pytest

from shared import topics
from tests.services.task.rig import Rig


def test_a_whole_carry_with_images() -> None:
    rig = Rig().begun().until("done", 120.0)
    states = list(dict.fromkeys(r.message.state for r in rig.said(topics.TASK_STATUS)))
    assert states == [
        *("idle", "calibrating", "searching", "approaching", "grasping", "carrying"),
        *("releasing", "retreating", "done"),
    ]
    assert all(r.header.valid for r in rig.said(topics.TASK_STATUS)[10:])
    assert not rig.toy.gripped
    assert rig.last(topics.TASK_STATUS).rotation == pytest.approx(np.pi / 2, abs=0.3)
    # Where it was grasped is where the panel really is.
    home = rig.task.machine._carry.home
    assert home.near(rig.toy.grasp, 0.015, 0.06)


def test_limits_are_the_paper_s_and_the_nominal_wrench_is_half_the_weight() -> None:
    rig = Rig().carrying()
    message = rig.last(topics.CONTROL_TARGET)
    assert message.force_limit.tolist() == [10.0, 10.0, 10.0]
    assert message.torque_limit.tolist() == [0.5, 3.0, 3.0]
    assert message.nominal_force.tolist() == pytest.approx([0.0, 0.0, -1.5 * 9.81 / 2])
    assert not message.nominal_torque.any()


def test_rates_while_carrying() -> None:
    rig = Rig().carrying()
    rig.forget()
    rig.run(5.0)
    assert len(rig.said(topics.CONTROL_TARGET)) >= 25
    assert len(rig.said(topics.BASE_ENABLE)) >= 25
    assert len(rig.said(topics.TASK_STATUS)) >= 25
    closing = rig.said(topics.COMMAND_GRIPPER)
    assert 10 <= len(closing) <= 13 and all(r.message.opening == 0.0 for r in closing)
    assert not rig.said(topics.COMMAND_HEAD)


def test_at_rest_the_arm_is_left_to_others() -> None:
    rig = Rig()
    rig.run(3.0)
    assert rig.state == "idle"
    assert not rig.said(topics.CONTROL_TARGET) and not rig.said(topics.COMMAND_GRIPPER)
    assert not any(r.message.enabled for r in rig.said(topics.BASE_ENABLE))


@pytest.mark.parametrize("word", ["jump", None, ["start"]])
def test_any_other_word_is_refused_with_those_that_there_are(word: object) -> None:
    rig = Rig()
    rig.run(1.0)
    rig.refuses_to(word, "command is .* wanted (one of start, abort, release, reset|text)")


def test_it_asks_for_a_tare() -> None:
    rig = Rig()
    rig.robot.compensation = "none"
    rig.begun().until("calibrating").run(3.0)
    assert rig.state == "calibrating" and "tandem tare" in rig.reason
    rig.robot.compensation = "tare"
    rig.until("carrying")


def test_a_zero_of_another_run_of_the_robot_does_not_do() -> None:
    rig = Rig()
    rig.robot.zero_age = -1.0
    rig.run(1.0)
    assert rig.state == "idle" and "no zero of the sensor from this run" in rig.reason
    rig.begun().until("calibrating").run(3.0)
    assert rig.state == "calibrating" and "tandem tare" in rig.reason
    rig.robot.zero_age = 1.0
    rig.until("carrying")


def test_an_old_zero_is_asked_to_be_measured_anew_before_the_carry_and_does_not_end_one() -> None:
    rig = Rig()
    rig.robot.zero_age, rig.robot.error_bound = 840.0, np.array((0.3, 0.3, 1.24, 0.16, 0.3, 0.3))
    old = "the zero is 14 min old and known to 1.2 N and 0.30 Nm only: let go of the tool and `tandem tare`"
    rig.run(1.0)
    assert rig.state == "idle" and rig.reason.endswith(old) and rig.reason.count(old) == 1
    rig.begun().until("calibrating").run(3.0)
    assert rig.state == "calibrating" and old in rig.reason
    rig.robot.zero_age = 1.0
    rig.until("carrying")
    rig.robot.zero_age = 900.0
    rig.run(5.0)
    assert rig.state == "carrying" and "the zero is" not in rig.reason


def test_an_old_zero_that_is_known_well_enough_is_good_enough() -> None:
    rig = Rig()
    rig.robot.zero_age, rig.robot.error_bound = 7200.0, np.array((2.9, 2.9, 2.9, 0.14, 0.8, 0.8))
    rig.begun().until("carrying")


def test_a_tare_is_not_enough_if_payload_is_wanted() -> None:
    rig = Rig(compensation="payload")
    rig.robot.compensation = "tare"
    rig.begun().until("calibrating").run(3.0)
    assert "tandem identify" in rig.reason


@pytest.mark.parametrize("key", [topics.STATE_GRIPPER.key, topics.STATE_EE.key])
def test_says_what_it_waits_for_at_the_start(key: str) -> None:
    rig = Rig()
    rig.robot.muted = {key}
    rig.run(1.0)
    assert rig.state == "idle" and key in rig.reason
    rig.refuses_to("start", "not yet")
    rig.robot.muted = set()
    rig.run(1.0)
    assert "ready" in rig.reason
    rig.tell("start")
