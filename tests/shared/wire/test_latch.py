"""A stop and a release are said until the robot shows them, and the newest word wins."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from shared.messages import ControlStatus, RobotStatus, Stop
from shared.schema.records import Record
from shared.topics import CONTROL_STATUS, STATE_ROBOT, STOP, Topic
from shared.wire.bus import OnPayload
from shared.wire.client import Client
from shared.wire.codec import decode
from shared.wire.latch import Latch
from shared.wire.publisher import Publisher
from tests.support.wait import eventually

ZERO = (0.0,) * 6


def status(mode: str) -> RobotStatus:
    return RobotStatus(mode, "", "omni", True, 0.25, 1.0, (0.5, 0.5, 1.0))


def control(reason: str) -> ControlStatus:
    return ControlStatus("braking", reason, "certified", ZERO, ZERO, ZERO, 0.0, 0.0, 0.0)


class Stage:
    """A bus on which a robot answers each stop as a test wants."""

    def __init__(self) -> None:
        self.listeners: dict[str, OnPayload] = {}
        self.said: list[Stop] = []
        self.answer: Callable[[Stop], tuple[tuple[Topic, Record], ...]] = lambda stop: ()
        self.client = Client(self)
        self._robot = Publisher(self, self.client.clock)
        self.latch = Latch(self.client, self.client.watch(STATE_ROBOT), self.client.watch(CONTROL_STATUS), within=0.5)

    def subscribe(self, key: str, on_payload: OnPayload) -> None:
        self.listeners[key] = on_payload

    def publish(self, key: str, payload: bytes) -> None:
        if key == STOP.key:
            _, stop = decode(Stop, payload, STOP.cap)
            self.said.append(stop)
            for topic, message in self.answer(stop):
                self._robot.publish(topic, message)
        else:
            self.listeners[key](payload)

    def obeys(self, stop: Stop) -> tuple[tuple[Topic, Record], ...]:
        return ((STATE_ROBOT, status("stopped" if stop.engaged else "ready")),)


@pytest.fixture
def stage() -> Stage:
    return Stage()


@pytest.mark.parametrize("engaged", [True, False])
def test_it_is_said_again_until_the_robot_shows_it(stage: Stage, engaged: bool) -> None:
    stage.answer = lambda stop: stage.obeys(stop) if len(stage.said) > 2 else ()
    assert stage.latch.say(Stop(engaged, "hand in the way")) == ""
    assert [(stop.engaged, stop.reason) for stop in stage.said] == [(engaged, "hand in the way")] * 3


def test_what_the_robot_showed_before_counts_for_nothing(stage: Stage) -> None:
    stage._robot.publish(STATE_ROBOT, status("stopped"))
    assert "sent, but no robot has answered" in stage.latch.say(Stop(True))


def test_a_robot_that_does_not_obey_is_told(stage: Stage) -> None:
    stage.answer = lambda stop: ((STATE_ROBOT, status("ready")),)
    said = stage.latch.say(Stop(True))
    assert said == "sent, but the robot does not show stopped within 0.5 s (it is ready)"


def test_a_controller_that_stays_latched_is_told_of_a_release_only(stage: Stage) -> None:
    latched = (CONTROL_STATUS, control("the sensor was silent: latched"))
    stage.answer = lambda stop: (*stage.obeys(stop), latched)
    assert stage.latch.say(Stop(True)) == ""
    assert "the robot is released, but not the controller: the sensor was" in stage.latch.say(Stop(False))


def test_a_stop_ends_a_release_that_is_still_being_said(stage: Stage) -> None:
    stage.answer = lambda stop: stage.obeys(stop) if stop.engaged else ()
    releases: list[str] = []
    releasing = threading.Thread(target=lambda: releases.append(stage.latch.say(Stop(False))))
    releasing.start()
    eventually(lambda: stage.said)
    assert stage.latch.say(Stop(True)) == ""
    releasing.join()
    words = [stop.engaged for stop in stage.said]
    assert words == sorted(words), "no release after the stop"
    assert "somebody wanted the contrary" in releases[0]
