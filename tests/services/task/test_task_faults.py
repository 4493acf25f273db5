"""What the task does while something is missing, wrong or stopped: it waits or holds, says why, and never lets go."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.task.geometry import Pose
from services.task.vision import detection
from shared import topics
from shared.messages import Stop
from tests.services.task.rig import Rig
from tests.services.task.toy import MARKER

BLINDED: dict[str, tuple[dict[str, Any], str]] = {
    "camera off": ({"muted": {topics.SENSOR_CAMERA.key}}, "no image for"),
    "camera frozen": ({"frozen": True}, "as a frozen camera's does"),
    "camera marked invalid": ({"valid": False}, "marked invalid"),
    "covered": ({"shown": None}, "covered"),
    "other marker": ({"number": 12}, "seen 12, wanted 7"),
}


@pytest.mark.parametrize("name", BLINDED)
def test_never_approaches_on_an_old_pose(name: str) -> None:
    changes, words = BLINDED[name]
    rig = Rig().begun().until("approaching")
    rig.run(1.5)
    vars(rig.robot).update(changes)
    # Half a second the last pose is still fresh.
    rig.run(0.7)
    where = rig.toy.tool
    rig.run(2.0)
    assert rig.state == "approaching" and words in rig.reason
    assert rig.toy.tool.near(where, 0.01, 0.03)
    rig.until("holding", 5.0)
    assert words in rig.reason
    assert rig.toy.tool.near(where, 0.01, 0.03)


def told_otherwise(**changes: Any) -> Any:
    """What the camera's messages say, with changes to fields."""
    return lambda image: image.replaced(**{name: change(getattr(image, name)) for name, change in changes.items()})


UNBELIEVED: dict[str, tuple[dict[str, Any], dict[str, Any], str, str]] = {
    "centre off": (
        {"reports": told_otherwise(intrinsics=lambda k: k + np.array((0, 0, 40, 0)))},
        {},
        "holding",
        "centre (cx, cy): -4",
    ),
    "marker larger than told": ({}, {"marker_size": 0.2}, "holding", "marker_size: 0.1"),
    "head that does not turn": ({"turns": False}, {}, "searching", "the camera's pose has not changed in 2 s"),
    "fisheye": ({"reports": told_otherwise(distortion_model=lambda _: "equidistant")}, {}, "searching", "a fisheye"),
}


@pytest.mark.parametrize("name", UNBELIEVED)
def test_a_camera_that_is_not_proven_is_not_gone_by(name: str) -> None:
    changes, parameters, state, words = UNBELIEVED[name]
    rig = Rig(**parameters)
    rig.robot.marker_size = 0.15
    vars(rig.robot).update(changes)
    rig.begun().until("searching").run(10.0)
    assert (rig.state, words in rig.reason) == (state, True), rig.reason
    assert rig.last(topics.TASK_STATUS).marker is None


def test_the_marker_is_seen_all_over_the_picture_before_the_approach_and_the_head_looks_back() -> None:
    rig = Rig().begun().until("searching")
    rig.forget()
    rig.until("approaching")
    places = [view.corners.mean(axis=0) for view in rig.task._sight.proof._views]
    assert (np.ptp(places, axis=0) > (0.3 * 640, 0.3 * 480)).all()
    last = rig.said(topics.COMMAND_HEAD)[-1].message
    assert (last.pan, last.tilt) == (rig.settings.head_pan, rig.settings.head_tilt)
    assert rig.last(topics.TASK_STATUS).marker is not None


def test_a_panel_that_is_moved_while_the_head_looks_at_it_is_looked_at_anew() -> None:
    rig = Rig().begun().until("searching")
    rig.run(1.5)
    rig.robot.shown = Pose(MARKER.position + np.array((0.0, 0.02, 0.0)), MARKER.rotation)
    rig.until("approaching", 8.0)
    assert any("the panel was moved by 1" in received.message.reason for received in rig.said(topics.TASK_STATUS))
    assert rig.last(topics.TASK_STATUS).marker.position == pytest.approx(rig.robot.shown.position, abs=0.01)


def test_a_camera_without_noise_is_gone_by_while_its_head_nods() -> None:
    rig = Rig()
    rig.robot._another = lambda image: image  # type: ignore[method-assign]
    rig.begun().until("approaching").run(1.0)
    pans = {received.message.pan for received in rig.said(topics.COMMAND_HEAD)[-6:]}
    assert rig.state == "approaching" and len(pans) == 2, "its pictures would all be the same, as a frozen camera's"
    rig.until("carrying")


def test_a_marker_that_jumps_is_waited_for_and_then_followed() -> None:
    rig = Rig().begun().until("approaching")
    rig.run(1.0)
    rig.robot.shown = Pose(MARKER.position + np.array((0.0, 0.2, 0.0)), MARKER.rotation)
    rig.until("searching", 2.0)
    assert any("marker" in received.message.reason for received in rig.said(topics.TASK_STATUS)[-5:])
    rig.until("approaching", 5.0)
    rig.run(8.0)
    assert rig.toy.tool.position[1] == pytest.approx(-0.1, abs=0.03)


def test_lost_wrench_while_carrying() -> None:
    rig = Rig().carrying()
    rig.robot.muted.add(topics.WRENCH_EXTERNAL.key)
    rig.run(1.0)
    assert rig.state == "carrying" and "waiting: wrench/external is" in rig.reason
    assert not rig.last(topics.BASE_ENABLE).enabled
    rig.until("holding", 4.0)
    assert rig.toy.gripped
    rig.run(0.6)
    health = rig.health.latest.message
    assert health.state == "degraded" and "wrench/external is" in health.detail
    assert not health.inputs[topics.WRENCH_EXTERNAL.key].ok
    rig.refuses_to("start", "cannot carry on")
    rig.robot.muted.clear()
    rig.run(1.0)
    assert rig.state == "holding" and rig.health.latest.message.state == "ok"
    assert rig.tell("start") == "carrying"
    rig.run(0.5)
    assert rig.last(topics.BASE_ENABLE).enabled


@pytest.mark.parametrize("key", [topics.CONTROL_STATUS.key, topics.STATE_EE.key])
def test_lost_controller_or_pose_while_carrying(key: str) -> None:
    rig = Rig().carrying()
    rig.robot.muted.add(key)
    rig.run(2.0)
    assert rig.state == "carrying" and key in rig.reason
    rig.robot.muted.clear()
    rig.run(1.5)
    assert rig.state == "carrying" and rig.last(topics.BASE_ENABLE).enabled
    rig.robot.muted.add(key)
    rig.until("holding", 8.0)
    assert rig.toy.gripped


@pytest.mark.parametrize("every", [1, 3])
def test_the_base_stands_as_soon_as_nobody_keeps_the_limits(every: int) -> None:
    rig = Rig()
    rig.robot.every = every
    rig.stack.add(Base(BaseParameters()))
    base = rig.stack.client.watch(topics.BASE_STATUS)
    rig.carrying()
    enables = rig.said(topics.BASE_ENABLE)
    before = len(enables)
    rig.run(3.0)
    assert all(r.message.enabled for r in enables[before:]) and base.latest.message.state == "following"
    last = rig.stack.now
    rig.robot.muted.add(topics.CONTROL_STATUS.key)
    rig.stack.run(1.0, lambda: base.latest.message.state != "following")
    # At 30 Hz three periods are 0.1 s, to which the task's step and the base's come.
    assert rig.stack.now - last <= (0.12 if every == 1 else 0.16)
    assert rig.state == "carrying", "a short silence is no reason to give up"
    rig.robot.muted.clear()
    rig.run(0.1)
    assert rig.last(topics.BASE_ENABLE).enabled


def test_the_base_stands_while_the_controller_waits() -> None:
    rig = Rig().carrying()
    rig.robot.control = "waiting"
    rig.run(0.1)
    assert rig.state == "carrying" and not rig.last(topics.BASE_ENABLE).enabled


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
    assert rig.state == "holding" and "a step of the task failed" in rig.reason
    assert not rig.last(topics.BASE_ENABLE).enabled and rig.toy.gripped
    left[0] = 0
    rig.run(1.0)
    assert rig.state == "holding" and "`start` carries on" in rig.reason
    assert rig.tell("start") == "carrying"


@pytest.mark.parametrize("valid", [True, False])
def test_any_stop_holds_until_a_valid_release_and_a_start(valid: bool) -> None:
    rig = Rig().carrying()
    rig.publish(topics.STOP, Stop(True, "hand in the way"), valid)
    rig.until("holding", 0.1)
    assert "hand in the way" in rig.reason
    rig.publish(topics.STOP, Stop(False), valid=False)
    rig.run(0.5)
    rig.refuses_to("start", "hand in the way")
    rig.publish(topics.STOP, Stop(False))
    rig.run(0.1)
    assert rig.tell("start") == "carrying"


def test_a_stop_with_a_reason_as_long_as_a_message_silences_nobody() -> None:
    rig = Rig().carrying()
    statuses = rig.said(topics.TASK_STATUS)
    before = len(statuses)
    rig.publish(topics.STOP, Stop(True, "x" * 65_400))
    rig.run(2.0)
    assert rig.state == "holding" and "xxx" in rig.reason
    assert len(statuses) - before >= 10


@pytest.mark.parametrize("held", [False, True])
def test_a_robot_that_was_restarted_is_held_where_it_is_now(held: bool) -> None:
    rig = Rig().carrying()
    if held:
        rig.tell("abort")
    rig.robot.muted |= {topics.STATE_EE.key}
    rig.run(1.5)
    rig.new_session()
    tool = rig.toy.tool
    where = rig.toy.tool = Pose(tool.position + np.array((0.0, 0.1, 0.2)), tool.rotation)
    rig.robot.muted.clear()
    rig.forget()
    rig.until("holding", 3.0)
    assert held or "restarted" in rig.reason
    rig.run(3.0)
    assert rig.toy.gripped and rig.state == "holding"
    targets = [r.message.position for r in rig.said(topics.CONTROL_TARGET) if r.header.valid]
    assert targets and np.allclose(targets, where.position, atol=0.01), "it is not sent back"


def test_unreadable_image_is_said() -> None:
    rig = Rig()
    image = rig.robot._image().replaced(data=b"nothing")
    rig.robot._image = lambda: image  # type: ignore[method-assign]
    rig.begun().until("searching").run(1.0)
    assert "cannot be read" in rig.reason and rig.runner.fault is None


def test_a_camera_that_lags_all_the_time_is_not_gone_by() -> None:
    rig = Rig()
    rig.lag = 2.0
    rig.begun().until("searching").run(5.0)
    assert rig.state == "searching" and "the camera lags: its image is 2." in rig.reason
    rig.lag = 0.1
    rig.until("approaching", 5.0)


def test_images_that_opencv_cannot_work_on_are_of_no_use_and_end_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = Rig().begun().until("approaching")
    image = rig.robot._sent
    assert image is not None
    noise = np.random.default_rng(0)
    wide = image.replaced(width=40_000, height=1, encoding="rgb8", data=bytes(120_000))
    rig.robot._another = lambda _: wide.replaced(data=noise.bytes(120_000))  # type: ignore[method-assign]
    rig.run(1.5)
    assert rig.state == "approaching" and "40000 x 1, allowed" in rig.reason
    monkeypatch.setattr(detection, "LONGEST_SIDE", 10**6)
    with pytest.raises(detection.BadImage, match="OpenCV cannot work on it"):
        detection.Detector(0.15).find(wide, (7, Pose.from_rpy((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))))
