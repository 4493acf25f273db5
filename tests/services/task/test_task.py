"""The service in one process under simulated time: a whole carry with real images, and what it publishes when."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from services.base.base import Base
from services.base.parameters import BaseParameters
from services.task.geometry import Pose
from services.task.parameters import TaskParameters
from services.task.task import Task
from shared.client import Client
from shared.clock import nanoseconds
from shared.messages import Stop
from shared.parameters import Refused
from shared.stack import Stack
from shared.topics import (
    BASE_ENABLE,
    BASE_STATUS,
    COMMAND_GRIPPER,
    COMMAND_HEAD,
    CONTROL_STATUS,
    CONTROL_TARGET,
    SENSOR_CAMERA,
    STATE_EE,
    STATE_GRIPPER,
    STOP,
    TASK_COMMAND,
    TASK_STATUS,
    WRENCH_EXTERNAL,
)
from tests.services.task.robot import TICK, Robot
from tests.services.task.toy import MARKER


class Rig:
    """A stack with the task, and a robot on it; the task can be killed and started again."""

    def __init__(self, folder: Path | None = None, **parameters: Any) -> None:
        self.stack = Stack()
        self.folder = folder
        self.settings = TaskParameters.of(parameters)
        self.robot = Robot(self.stack.client.watch, self.settings)
        self.publisher = Client(self.stack.bus, self.stack.scheduler.clock)
        self.leads = True
        self._ticks = 0
        self.start_task()
        self.stack.scheduler.soon(self._tick)

    def start_task(self) -> None:
        self.task = Task(self.settings, lambda: self.stack.now, self.folder)
        self.runner = self.stack.add(self.task)

    def kill_task(self) -> None:
        """As SIGKILL does: it says nothing any more."""
        self.runner.poll = lambda behind=False: None  # type: ignore[method-assign]
        self.runner.next_deadline = lambda: 2**62  # type: ignore[method-assign]
        self.stack.bus._servers.pop(TASK_COMMAND.key, None)

    def restart_robot(self) -> None:
        self.publisher = Client(self.stack.bus, self.stack.scheduler.clock)

    def _tick(self) -> None:
        if self.leads:
            self.robot.person()
        for topic, message, valid in self.robot.tick(self._ticks):
            self.publisher.publish(topic, message, valid)
        self._ticks += 1
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(TICK), self._tick)

    def ask(self, command: str) -> str:
        return self.stack.client.ask(TASK_COMMAND, {"command": command})["state"]

    def until(self, state: str, within: float = 60.0) -> Rig:
        self.stack.run(within, lambda: self.robot.state == state)
        assert self.robot.state == state, f"{self.robot.state}: {self.robot.reason}"
        return self

    def run(self, duration: float) -> Rig:
        self.stack.run(duration)
        return self

    def begun(self) -> Rig:
        self.run(1.0)
        self.ask("start")
        return self

    def carrying(self) -> Rig:
        self.begun().until("carrying")
        self.leads = False
        self.robot.toy.lifted = True
        return self.run(2.0)

    @property
    def target(self) -> Pose:
        message = self.robot.last(CONTROL_TARGET)
        return Pose.of(message.position, message.orientation)


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
    assert 4 <= len(closing) <= 6 and all(r.message.opening == 0.0 for r in closing)
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
    with pytest.raises(Refused, match="cannot carry on"):
        rig.ask("start")
    rig.robot.muted.clear()
    rig.run(1.0)
    assert rig.robot.state == "holding"
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


def test_robot_restarted_while_carrying_holds_where_it_is_now() -> None:
    rig = Rig().carrying()
    rig.robot.muted |= {STATE_EE.key}
    rig.run(1.5)
    rig.restart_robot()
    rig.robot.muted.clear()
    rig.until("holding", 3.0)
    assert "restarted" in rig.robot.reason and rig.robot.toy.gripped


def test_killed_and_restarted_while_carrying_goes_on_without_a_jump(tmp_path: Path) -> None:
    rig = Rig(tmp_path).carrying()
    rig.robot.toy.far_height = float(rig.robot.toy.tool.position[2]) - 0.15
    rig.run(1.2)
    before, nominal = rig.target, rig.robot.last(CONTROL_TARGET).nominal_force[2]
    rig.kill_task()
    rig.run(3.0)
    for received in rig.robot.received.values():
        received.clear()
    rig.start_task()
    rig.run(2.0)
    assert rig.robot.state == "carrying"
    first = rig.robot.received[CONTROL_TARGET.key][0].message
    again = Pose.of(first.position, first.orientation)
    assert np.allclose(again.position[:2], before.position[:2], atol=1e-9)
    assert abs(again.position[2] - rig.robot.toy.tool.position[2]) < 0.05
    assert first.nominal_force[2] == pytest.approx(nominal)
    assert all(r.message.opening == 0.0 for r in rig.robot.received[COMMAND_GRIPPER.key])
    assert rig.robot.toy.gripped
    rig.leads = True
    rig.until("done", 90.0)


def test_an_abort_before_a_restart_is_ready_is_kept(tmp_path: Path) -> None:
    rig = Rig(tmp_path).carrying()
    rig.kill_task()
    rig.run(1.0)
    rig.start_task()
    rig.run(0.2)
    assert rig.ask("abort") == "holding"
    for received in rig.robot.received.values():
        received.clear()
    rig.run(1.0)
    assert rig.robot.state == "holding" and "aborted" in rig.robot.reason
    assert not any(r.message.enabled for r in rig.robot.received[BASE_ENABLE.key])
    assert rig.ask("start") == "carrying"


def test_restarted_when_idle_it_is_idle(tmp_path: Path) -> None:
    rig = Rig(tmp_path).begun().until("done", 120.0)
    rig.kill_task()
    rig.start_task()
    rig.run(2.0)
    assert rig.robot.state == "idle"
    assert not list((tmp_path / "task").iterdir())


def test_shutdown_leaves_grip_and_target_and_stops_the_base() -> None:
    rig = Rig().carrying()
    for received in rig.robot.received.values():
        received.clear()
    rig.runner.close()
    rig.stack.run(0.005)
    assert [r.message.enabled for r in rig.robot.received[BASE_ENABLE.key]] == [False]
    assert not rig.robot.received[COMMAND_GRIPPER.key]


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
