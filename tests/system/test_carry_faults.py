"""What goes wrong in the middle of a carry, in simulated time: nothing is dropped, it says why, and it can go on."""

from __future__ import annotations

from pathlib import Path

import pytest

from shared.messages import Stop
from shared.parameters import Refused
from shared.topics import STOP
from tests.support.carry_rig import CarryRig

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
STANDS = 0.02
"""Way [m] that tool and base may still make while they stand: braking from full speed takes most of it."""


@pytest.fixture
def rig(tmp_path: Path) -> CarryRig:
    return CarryRig(tmp_path)


def completes(rig: CarryRig) -> None:
    rig.reaches("done")
    verdict = rig.verdict
    assert verdict.completed, verdict


def test_a_task_killed_while_carrying_carries_on_when_it_is_started_again(rig: CarryRig) -> None:
    rig.carry_up_to("move")
    rig.stack.run(2.0)
    rig.stack.kill(rig.services.runners["task"])
    rig.stack.run(1.5)
    assert rig.verdict.gap is None and not rig.verdict.dropped
    rig.services.start_task()
    rig.says("carrying; to be set down")
    completes(rig)


@pytest.mark.parametrize("duration", [1.0, 10.0])
def test_without_a_wrench_everything_stands_until_a_person_says_that_it_may_go_on(
    rig: CarryRig, duration: float
) -> None:
    rig.carry_up_to("move")
    rig.stack.run(2.0)
    rig.sim("fault", target="ft", kind="off")
    rig.stack.run(0.5)
    assert max(rig.movement(duration - 0.5)) < STANDS
    rig.sim("fault", target="ft", kind="ok")
    rig.reaches("holding")
    assert "silent" in rig.task.reason
    rig.stack.run(1.0)
    with pytest.raises(Refused, match="tandem resume"):
        rig.tell("start")
    rig.client.publish(STOP, Stop(False))
    rig.stack.run(1.0)
    rig.tell("start")
    completes(rig)


def test_without_a_camera_it_waits_says_why_and_goes_on(rig: CarryRig) -> None:
    rig.sim("fault", target="camera", kind="off")
    rig.says("Is the camera on?")
    assert rig.task.state == "searching"
    assert max(rig.movement(5.0)) < STANDS
    rig.sim("fault", target="camera", kind="ok")
    rig.reaches("carrying")


def test_a_marker_covered_before_the_grasp_makes_it_wait_and_say_why(rig: CarryRig) -> None:
    rig.reaches("approaching")
    rig.stack.run(1.0)
    rig.sim("cover_marker")
    rig.says("waiting: no marker in sight: is it covered")
    assert rig.task.state == "approaching"
    assert max(rig.movement(2.0)) < STANDS
    rig.reaches("holding")
    assert "no marker in sight" in rig.task.reason and rig.verdict.end == "holding"


def test_without_the_base_the_arm_still_follows_and_holds(rig: CarryRig) -> None:
    rig.carry_up_to("move")
    rig.stack.run(2.0)
    rig.stack.kill(rig.services.runners["base"])
    rig.stack.run(1.5)
    tool, base = rig.movement(1.0)
    assert base == 0.0
    tool, base = rig.movement(15.0)
    assert base == 0.0 and tool > 0.02
    assert rig.verdict.gap is None and not rig.verdict.dropped


def test_a_stop_makes_everything_stand_and_it_carries_on_after_it(rig: CarryRig) -> None:
    rig.carry_up_to("move")
    rig.stack.run(2.0)
    rig.client.publish(STOP, Stop(True, "red button"))
    rig.stack.run(1.0)
    assert max(rig.movement(4.0)) < 1e-3
    assert rig.task.state == "holding" and "red button" in rig.task.reason
    with pytest.raises(Refused, match="red button"):
        rig.tell("start")
    rig.client.publish(STOP, Stop(False))
    rig.stack.run(1.0)
    rig.tell("start")
    completes(rig)
