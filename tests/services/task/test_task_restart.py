"""The task is killed and started again, or ended: grip and target stay, and a carry goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from services.task.geometry import Pose
from shared import topics
from tests.services.task.rig import Rig


def test_killed_and_restarted_while_carrying_goes_on_without_a_jump(tmp_path: Path) -> None:
    rig = Rig(tmp_path).carrying()
    rig.toy.far_height = float(rig.toy.tool.position[2]) - 0.15
    rig.run(1.2)
    before, nominal = rig.target, rig.last(topics.CONTROL_TARGET).nominal_force[2]
    rig.kill_task()
    rig.run(3.0)
    rig.forget()
    rig.start_task()
    rig.run(2.0)
    assert rig.state == "carrying"
    first = rig.said(topics.CONTROL_TARGET)[0].message
    again = Pose.of(first.position, first.orientation)
    assert np.allclose(again.position[:2], before.position[:2], atol=1e-9)
    assert abs(again.position[2] - rig.toy.tool.position[2]) < 0.05
    assert first.nominal_force[2] == pytest.approx(nominal)
    assert all(r.message.opening == 0.0 for r in rig.said(topics.COMMAND_GRIPPER))
    assert rig.toy.gripped
    rig.leads = True
    rig.until("done", 90.0)


def test_an_abort_before_a_restart_is_ready_is_kept(tmp_path: Path) -> None:
    rig = Rig(tmp_path).carrying()
    rig.kill_task()
    rig.run(1.0)
    rig.start_task()
    rig.run(0.2)
    assert rig.tell("abort") == "holding"
    rig.forget()
    rig.run(1.0)
    assert rig.state == "holding" and "aborted" in rig.reason
    assert not any(r.message.enabled for r in rig.said(topics.BASE_ENABLE))
    assert rig.tell("start") == "carrying"


def test_restarted_when_idle_it_is_idle(tmp_path: Path) -> None:
    rig = Rig(tmp_path).begun().until("done", 120.0)
    rig.kill_task()
    rig.start_task()
    rig.run(2.0)
    assert rig.state == "idle"
    assert not list((tmp_path / "task").iterdir())


def test_shutdown_leaves_grip_and_target_and_stops_the_base() -> None:
    rig = Rig().carrying()
    rig.forget()
    rig.runner.close()
    rig.stack.run(0.005)
    assert [r.message.enabled for r in rig.said(topics.BASE_ENABLE)] == [False]
    assert not rig.said(topics.COMMAND_GRIPPER)


@pytest.mark.parametrize("flickers", [0.1, 1.0])
def test_a_gripper_that_says_for_a_moment_that_it_holds_nothing_has_not_lost_the_panel(
    tmp_path: Path, flickers: float
) -> None:
    rig = Rig(tmp_path).carrying()
    rig.kill_task()
    rig.run(0.5)
    rig.robot.denies = True
    rig.start_task()
    rig.run(0.5 + flickers)
    rig.robot.denies = False
    rig.run(1.0)
    assert rig.state == ("carrying" if flickers < 0.3 else "idle"), rig.reason


def test_without_its_journal_it_lets_go_as_told_and_carries_nothing_on(tmp_path: Path) -> None:
    rig = Rig(tmp_path).carrying()
    rig.kill_task()
    for path in (tmp_path / "task").iterdir():
        path.write_text("torn")
    rig.start_task()
    rig.until("holding", 3.0)
    rig.refuses_to("start", "nothing is known of how far the panel is turned")
    assert rig.tell("release") == "releasing"
    rig.run(3.0)
    assert rig.toy.gripped, "the robot carries half of it"
    rig.toy.lifted = False
    rig.until("done", 30.0)
