"""What the task does while something is missing, wrong or stopped: it waits or holds, says why, and never lets go."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.task.geometry import Pose
from services.task.vision import detection
from shared.messages import Stop
from shared.parameters import Refused
from shared.topics import (
    BASE_ENABLE,
    BASE_STATUS,
    CONTROL_STATUS,
    CONTROL_TARGET,
    SENSOR_CAMERA,
    STATE_EE,
    STOP,
    TASK_STATUS,
    WRENCH_EXTERNAL,
)
from tests.services.task.rig import Rig
from tests.services.task.robot import Robot
from tests.services.task.toy import MARKER


def silence(key: str) -> Callable[[Rig], None]:
    return lambda rig: rig.robot.muted.add(key)


def other_marker(rig: Rig) -> None:
    rig.robot.number = 12


def cover(rig: Rig) -> None:
    rig.robot.shown = None


def jump(rig: Rig) -> None:
    rig.robot.shown = Pose(MARKER.position + np.array((0.0, 0.2, 0.0)), MARKER.rotation)


def freeze(rig: Rig) -> None:
    rig.robot.frozen = True


def doubt(rig: Rig) -> None:
    rig.robot.valid = False


BLINDED = {
    "camera off": (silence(SENSOR_CAMERA.key), "no image for"),
    "camera frozen": (freeze, "always the same one"),
    "camera marked invalid": (doubt, "marked invalid"),
    "covered": (cover, "covered"),
    "other marker": (other_marker, "seen 12, wanted 7"),
}


@pytest.mark.parametrize("name", BLINDED)
def test_never_approaches_on_an_old_pose(name: str) -> None:
    blind, words = BLINDED[name]
    rig = Rig().begun().until("approaching")
    rig.run(1.5)
    blind(rig)
    # Half a second the last pose is still fresh.
    rig.run(0.7)
    where = rig.robot.toy.tool
    rig.run(2.0)
    assert rig.robot.state == "approaching" and words in rig.robot.reason
    assert rig.robot.toy.tool.near(where, 0.01, 0.03)
    rig.until("holding", 5.0)
    assert words in rig.robot.reason
    assert rig.robot.toy.tool.near(where, 0.01, 0.03)


def test_a_marker_that_jumps_is_waited_for_and_then_followed() -> None:
    rig = Rig().begun().until("approaching")
    rig.run(1.0)
    jump(rig)
    rig.run(0.7)
    assert "marker" in rig.robot.reason
    rig.run(2.0)
    assert rig.robot.state == "approaching"
    rig.run(8.0)
    assert rig.robot.toy.tool.position[1] == pytest.approx(-0.1, abs=0.03)


def test_lost_wrench_while_carrying() -> None:
    rig = Rig().carrying()
    rig.robot.muted.add(WRENCH_EXTERNAL.key)
    rig.run(1.0)
    assert rig.robot.state == "carrying" and "waiting: wrench/external is" in rig.robot.reason
    assert not rig.robot.last(BASE_ENABLE).enabled
    rig.until("holding", 4.0)
    assert rig.robot.toy.gripped
    rig.run(0.6)
    health = rig.health.latest.message
    assert health.state == "degraded" and "wrench/external is" in health.detail
    assert not health.inputs[WRENCH_EXTERNAL.key].ok
    with pytest.raises(Refused, match="cannot carry on"):
        rig.ask("start")
    rig.robot.muted.clear()
    rig.run(1.0)
    assert rig.robot.state == "holding" and rig.health.latest.message.state == "ok"
    assert rig.ask("start") == "carrying"
    rig.run(0.5)
    assert rig.robot.last(BASE_ENABLE).enabled


@pytest.mark.parametrize("key", [CONTROL_STATUS.key, STATE_EE.key])
def test_lost_controller_or_pose_while_carrying(key: str) -> None:
    rig = Rig().carrying()
    rig.robot.muted.add(key)
    rig.run(2.0)
    assert rig.robot.state == "carrying" and key in rig.robot.reason
    rig.robot.muted.clear()
    rig.run(1.5)
    assert rig.robot.state == "carrying" and rig.robot.last(BASE_ENABLE).enabled
    rig.robot.muted.add(key)
    rig.until("holding", 8.0)
    assert rig.robot.toy.gripped


@pytest.mark.parametrize("every", [1, 3])
def test_the_base_stands_as_soon_as_nobody_keeps_the_limits(every: int) -> None:
    rig = Rig()
    rig.robot.every = every
    rig.stack.add(Base(BaseParameters()))
    base = rig.stack.client.watch(BASE_STATUS)
    rig.carrying()
    enables = rig.robot.received[BASE_ENABLE.key]
    before = len(enables)
    rig.run(3.0)
    assert all(r.message.enabled for r in enables[before:]) and base.latest.message.state == "following"
    last = rig.stack.now
    rig.robot.muted.add(CONTROL_STATUS.key)
    rig.stack.run(1.0, lambda: base.latest.message.state != "following")
    # At 30 Hz three periods are 0.1 s, to which the task's step and the base's come.
    assert rig.stack.now - last <= (0.12 if every == 1 else 0.16)
    assert rig.robot.state == "carrying", "a short silence is no reason to give up"
    rig.robot.muted.clear()
    rig.run(0.1)
    assert rig.robot.last(BASE_ENABLE).enabled


def test_the_base_stands_while_the_controller_waits() -> None:
    rig = Rig().carrying()
    rig.robot.control = "waiting"
    rig.run(0.1)
    assert rig.robot.state == "carrying" and not rig.robot.last(BASE_ENABLE).enabled


@pytest.mark.parametrize("failing", [1, 1000])
def test_a_step_that_fails_holds_and_does_not_go_on_by_itself(failing: int) -> None:
    rig = Rig().carrying()
    look, left = rig.task._observer.look, [failing]

    def fail(*arguments: Any) -> Any:
        left[0] -= 1
        if left[0] < 0:
            return look(*arguments)
        raise ValueError("boom")

    rig.task._observer.look = fail  # type: ignore[method-assign]
    rig.run(0.2)
    assert rig.robot.state == "holding" and "a step of the task failed" in rig.robot.reason
    assert not rig.robot.last(BASE_ENABLE).enabled and rig.robot.toy.gripped
    left[0] = 0
    rig.run(1.0)
    assert rig.robot.state == "holding" and "`start` carries on" in rig.robot.reason
    assert rig.ask("start") == "carrying"


def test_stop_holds_until_it_is_released_and_started() -> None:
    rig = Rig().carrying()
    rig.stack.client.publish(STOP, Stop(True, "hand in the way"))
    rig.run(0.3)
    assert rig.robot.state == "holding" and "hand in the way" in rig.robot.reason
    with pytest.raises(Refused, match="hand in the way"):
        rig.ask("start")
    rig.stack.client.publish(STOP, Stop(False))
    rig.run(0.3)
    assert rig.ask("start") == "carrying"


def test_a_stop_with_a_reason_as_long_as_a_message_silences_nobody() -> None:
    rig = Rig().carrying()
    statuses = rig.robot.received[TASK_STATUS.key]
    before = len(statuses)
    rig.stack.client.publish(STOP, Stop(True, "x" * 65_400))
    rig.run(2.0)
    assert rig.robot.state == "holding" and "xxx" in rig.robot.reason
    assert len(statuses) - before >= 10


def restarted_elsewhere(rig: Rig) -> Pose:
    """The robot falls silent, and comes back in a new session with its tool somewhere else: there."""
    rig.robot.muted |= {STATE_EE.key}
    rig.run(1.5)
    rig.restart_robot()
    tool = rig.robot.toy.tool
    rig.robot.toy.tool = Pose(tool.position + np.array((0.0, 0.1, 0.2)), tool.rotation)
    rig.robot.muted.clear()
    for received in rig.robot.received.values():
        received.clear()
    return rig.robot.toy.tool


def only_wants(rig: Rig, where: Pose) -> bool:
    """Whether there were targets since, and every valid one is there."""
    targets = [r.message.position for r in rig.robot.received[CONTROL_TARGET.key] if r.header.valid]
    return bool(targets) and np.allclose(targets, where.position, atol=0.01)


def test_robot_restarted_while_carrying_holds_where_it_is_now() -> None:
    rig = Rig().carrying()
    where = restarted_elsewhere(rig)
    rig.until("holding", 3.0)
    assert "restarted" in rig.robot.reason and rig.robot.toy.gripped
    rig.run(1.0)
    assert only_wants(rig, where)


def test_unreadable_image_is_said() -> None:
    rig = Rig()
    rig.robot._image = lambda: type(image)(  # type: ignore[method-assign]
        640,
        480,
        "jpeg",
        b"nothing",
        image.intrinsics,
        image.distortion,
        image.position,
        image.orientation,
    )
    image = Robot._image(rig.robot)
    rig.begun().until("searching").run(1.0)
    assert "of no use" in rig.robot.reason and rig.runner.fault is None


def test_a_camera_that_lags_all_the_time_is_not_gone_by() -> None:
    rig = Rig()
    rig.lag = 2.0
    rig.begun().until("searching").run(5.0)
    assert rig.robot.state == "searching" and "the camera lags: its image is 2." in rig.robot.reason
    rig.lag = 0.1
    rig.until("approaching", 5.0)


def test_images_that_opencv_cannot_work_on_are_of_no_use_and_end_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = Rig().begun().until("approaching")
    image = rig.robot._sent
    assert image is not None
    noise = np.random.default_rng(0)
    wide = image.replaced(width=40_000, height=1, encoding="rgb8", data=bytes(120_000))
    rig.robot._another = lambda _: wide.replaced(data=noise.bytes(120_000))  # type: ignore[method-assign]
    rig.run(1.5)
    assert rig.robot.state == "approaching" and "40000 x 1, allowed" in rig.robot.reason
    monkeypatch.setattr(detection, "LONGEST_SIDE", 10**6)
    with pytest.raises(detection.BadImage, match="OpenCV cannot work on it"):
        detection.Detector(0.15).find(wide, (7, Pose.from_rpy((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))))


def test_a_robot_that_was_restarted_while_it_was_held_is_held_where_it_is() -> None:
    rig = Rig().carrying()
    rig.ask("abort")
    where = restarted_elsewhere(rig)
    rig.run(3.0)
    assert only_wants(rig, where)
    assert rig.robot.toy.gripped and rig.robot.state == "holding"
