"""What a person does from the page is asked of the robot, and answered in its words."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from services.viewer.page.actions import REASON, Actions
from shared.messages import Stop
from shared.topics import SIM_COMMAND, TASK_COMMAND
from shared.wire.bus import NoReply, OnPayload
from shared.wire.client import Client
from shared.wire.codec import decode_map, encode_map
from shared.wire.credentials import Credentials
from tests.support.closed import make

Answers = Callable[[dict[str, Any]], dict[str, Any]]


class Robot:
    """A bus with somebody who answers as a test wants, or nobody."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.answers: Answers | None = None

    def query(self, key: str, payload: bytes, timeout: float) -> bytes:
        self.asked.append((key, decode_map(payload)))
        if self.answers is None:
            raise NoReply(key)
        return encode_map(self.answers(self.asked[-1][1]))

    def living(self) -> set[str]:
        return {"task"}

    def subscribe(self, key: str, on_payload: OnPayload) -> None: ...


class Said:
    """A latch that notes what it is to say."""

    def __init__(self) -> None:
        self.words: list[Stop] = []
        self.problem = ""

    def say(self, message: Stop) -> str:
        self.words.append(message)
        return self.problem


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch) -> Robot:
    monkeypatch.delenv("TANDEM_SECURE", raising=False)
    return Robot()


@pytest.fixture
def latch() -> Said:
    return Said()


@pytest.fixture
def actions(robot: Robot, latch: Said) -> Actions:
    return of(robot, latch)


def of(robot: Robot, latch: Said, credentials: Credentials | None = None) -> Actions:
    return Actions(Client(robot, credentials=credentials), latch)  # type: ignore[arg-type]


def test_a_stop_and_a_release_go_to_the_latch(actions: Actions, latch: Said) -> None:
    assert actions.stop({}) == (True, "stopped: the robot shows it")
    assert actions.release({}) == (True, "released: the robot may move")
    assert [(word.engaged, word.reason) for word in latch.words] == [(True, REASON), (False, "released on the page")]


def test_a_stop_that_is_not_shown_is_told(actions: Actions, latch: Said) -> None:
    latch.problem = "sent, but no robot has answered"
    assert actions.stop({}) == actions.release({}) == (False, latch.problem)


@pytest.mark.parametrize("command", ["start", "abort", "release", "reset"])
def test_the_task_is_told_and_its_state_told_back(actions: Actions, robot: Robot, command: str) -> None:
    robot.answers = lambda asked: {"ok": True, "state": "carrying"}
    assert actions.task({"command": command}) == (True, "accepted: the task is carrying")
    assert robot.asked == [(TASK_COMMAND.key, {"command": command})]


@pytest.mark.parametrize("wanted", [{"target": [1.0, 0.0, 0.8]}, {"script": '[[phase]]\ndo = "take_hold"'}])
def test_the_hands_are_led_or_given_a_script(actions: Actions, robot: Robot, wanted: dict[str, Any]) -> None:
    robot.answers = lambda asked: {"ok": True}
    assert actions.hand(wanted) == (True, "accepted")
    ((key, asked),) = robot.asked
    assert key == SIM_COMMAND.key and asked["command"] == "hand"
    assert {name: value for name, value in asked.items() if value is not None} == {"command": "hand", **wanted}


def test_a_refusal_comes_in_the_robot_s_words(actions: Actions, robot: Robot) -> None:
    robot.answers = lambda asked: {"ok": False, "error": "start in state holding: `reset` first"}
    assert actions.task({"command": "start"}) == (False, "task refused: start in state holding: `reset` first")


def test_silence_says_who_is_silent(actions: Actions) -> None:
    done, said = actions.task({"command": "start"})
    assert not done and said.startswith("no answer on task/command within 3 s: task lives, but does not answer")
    assert "robot is not running" in actions.hand({"target": [1.0, 0.0, 0.8]}).said


@pytest.mark.parametrize(
    ("action", "asked", "said"),
    [
        ("task", {}, "command"),
        ("task", {"command": "explode"}, "start, abort, release, reset"),
        ("task", {"command": ["start"]}, "command"),
        ("hand", {}, "script.* or target"),
        ("hand", {"target": [1.0, 0.0]}, "target has 2 elements"),
        ("hand", {"target": [1e9, 0.0, 0.0]}, "target"),
        ("hand", {"target": "there"}, "target"),
        ("hand", {"target": [1.0, 0.0, 0.8], "script": "carry"}, "script.* or target"),
    ],
)
def test_what_is_no_request_is_refused_here(
    actions: Actions, robot: Robot, action: str, asked: dict[str, Any], said: str
) -> None:
    done, why = getattr(actions, action)(asked)
    assert not done and "\n" not in why
    assert re.search(said, why), why
    assert not robot.asked


@pytest.mark.parametrize(("participant", "able"), [("viewer", False), ("page", True), ("operator", True)])
def test_a_certificate_that_may_not_act_is_named(
    robot: Robot, latch: Said, tmp_path: Path, participant: str, able: bool
) -> None:
    make(tmp_path, "--only", participant)
    robot.answers = lambda asked: {"ok": True, "state": "idle"}
    actions = of(robot, latch, Credentials.of(str(tmp_path / participant)))
    assert {name: not why for name, why in actions.forbidden.items()} == dict.fromkeys(
        ("stop", "enable", "task", "hand"), able
    )
    done, said = actions.task({"command": "start"})
    assert done == able and bool(robot.asked) == able
    if not able:
        assert said == actions.forbidden["task"]
        assert f"the certificate of tiago.{participant} may not ask task/command" in said
