"""The page of a viewer that runs, beside a robot that runs: what a browser would ask, asked without one."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from shared.messages import TwistCommand
from shared.topics import CONTROL_STATUS, SENSOR_CAMERA, SENSOR_FT, STATE_ROBOT
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.contract.robot import NAME, Commander, Robot
from tests.services.viewer.page.conftest import Browser
from tests.support.closed import make
from tests.support.ports import free_port
from tests.support.processes import Process
from tests.support.wait import eventually

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

PATIENCE = 60.0  # [s]: the first viewer on a machine takes rerun's page out of its package


class Viewer(Browser):
    """A viewer as a process, and a browser that has opened its page."""

    def __init__(self, start: StartProcess, endpoint: str, *options: str) -> None:
        self.process: Process = start("services.viewer", "--connect", endpoint, "--port", "0", *options)
        self.process.wait_for_output("Ctrl-C ends it", PATIENCE)
        found = re.search(r"http://127.0.0.1:(\d+)/", self.process.output)
        assert found is not None
        self.port = int(found[1])
        self.host = f"127.0.0.1:{self.port}"

    def state(self) -> dict[str, Any]:
        return json.loads(self.get("/state").body)

    def shows(self, mode: str) -> Callable[[], bool]:
        return lambda: (self.state()["gate"] or {}).get("mode") == mode

    def does(self, path: str, **asked: Any) -> tuple[bool, str]:
        answer = json.loads(self.post(path, json.dumps(asked).encode()).body)
        return answer["ok"], answer["said"]


def test_a_stop_latches_the_robot_until_it_is_released(start: StartProcess, router: Router) -> None:
    start("services.mock", "--connect", router.endpoint)
    viewer = Viewer(start, router.endpoint)
    eventually(lambda: viewer.state()["gate"], PATIENCE)
    assert viewer.does("/stop") == (True, "stopped: the robot shows it")
    eventually(viewer.shows("stopped"), PATIENCE)
    assert "STOP on the page" in viewer.state()["sentence"]["text"]
    bus = ZenohBus(connect=router.endpoint)
    gate = Client(bus).watch(STATE_ROBOT)
    eventually(lambda: gate.latest, PATIENCE)
    assert gate.latest is not None and gate.latest.message.mode == "stopped"
    bus.close()
    assert viewer.does("/release") == (True, "released: the robot may move")
    eventually(lambda: not viewer.shows("stopped")(), PATIENCE)
    done, said = viewer.does("/task", command="start")
    assert not done and "task is not running" in said
    viewer.process.ends_in_time()


def test_the_button_that_is_held_lets_the_robot_move(start: StartProcess, router: Router) -> None:
    robot, commander = Robot(router.endpoint), Commander(router.endpoint)
    start("services.mock", *robot.options, "--set", "require_enable=true")
    viewer = Viewer(start, router.endpoint, "--robot", NAME)
    robot.started()
    commander.make = lambda: TwistCommand((0.05, 0.0, 0.0), (0.0, 0.0, 0.0), 0.1)
    eventually(lambda: "enabling device" in (viewer.state()["gate"] or {}).get("reason", ""), PATIENCE)
    assert viewer.state()["gate"]["require_enable"] and robot.speed == 0.0

    def held() -> bool:
        assert viewer.does("/enable", pressed=True) == (True, "")
        return robot.speed > 0.0

    eventually(held, PATIENCE, "it moves while the page says so")
    assert viewer.does("/enable", pressed=False)[0]
    eventually(lambda: robot.speed == 0.0, PATIENCE, "it stands")
    commander.close()
    robot.close()
    viewer.process.ends_in_time()


def test_a_robot_that_hangs_and_a_router_that_is_gone_are_told(start: StartProcess, router: Router) -> None:
    robot = start("services.mock", "--connect", router.endpoint)
    viewer = Viewer(start, router.endpoint)
    eventually(lambda: viewer.state()["gate"], PATIENCE)
    robot.signal(signal.SIGSTOP)
    eventually(lambda: viewer.state()["gate"]["age"] > 2.0, PATIENCE, "its age grows")
    done, said = viewer.does("/stop")
    assert not done and said.startswith("sent, but no robot has answered")
    robot.signal(signal.SIGCONT)
    router.process.kill()
    eventually(lambda: "router is gone" in viewer.state()["sentence"]["text"], PATIENCE)
    assert not viewer.does("/stop")[0]
    viewer.process.ends_in_time()


def test_a_certificate_that_may_only_read_shows_all_and_acts_on_nothing(start: StartProcess, tmp_path: Path) -> None:
    keys = make(tmp_path / "keys")
    endpoint = f"tls/127.0.0.1:{free_port()}"
    start("services.router", "--listen", endpoint, "--secure", str(keys / "router")).wait_for_output("listening")
    start("services.mock", "--connect", endpoint, "--secure", str(keys / "mock"))
    reader = Viewer(start, endpoint, "--secure", str(keys / "viewer"))
    eventually(lambda: reader.state()["gate"], PATIENCE)
    assert all("the certificate of tiago.viewer may not" in why for why in reader.state()["forbidden"].values())
    done, said = reader.does("/stop")
    assert not done and said == reader.state()["forbidden"]["stop"]
    assert not reader.shows("stopped")()
    reader.process.ends_in_time()
    page = Viewer(start, endpoint, "--secure", str(keys / "page"))
    eventually(lambda: page.state()["gate"], PATIENCE)
    assert page.does("/stop")[0] and page.does("/release")[0]
    assert page.state()["forbidden"]["stop"] == page.state()["forbidden"]["task"] == ""


def test_a_taken_port_is_one_line(start: StartProcess, router: Router) -> None:
    first = Viewer(start, router.endpoint)
    for port in (first.port, first.port - 1):
        second = start("services.viewer", "--connect", router.endpoint, "--port", str(port))
        second.refuses("viewer: the page on 127.0.0.1:", "address already in use; choose another port")


def test_what_comes_often_is_asked_for_only_while_somebody_looks(start: StartProcess, router: Router) -> None:
    viewer = Viewer(start, router.endpoint)
    often = SENSOR_CAMERA.key, SENSOR_FT.key, CONTROL_STATUS.key
    with closing(ZenohBus(connect=router.endpoint)) as robot:

        def wanted() -> list[bool]:
            return [robot.wanted(key) for key in often]

        eventually(lambda: robot.wanted(STATE_ROBOT.key) and not any(wanted()), PATIENCE, "what comes seldom is heard")
        eventually(lambda: viewer.state() and all(wanted()), PATIENCE, "who looks sees all")
        eventually(lambda: not any(wanted()), PATIENCE, "nobody looks any more")
        assert robot.wanted(STATE_ROBOT.key)
