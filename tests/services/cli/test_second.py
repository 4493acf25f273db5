"""A command that publishes beside another one is told at once who is first, and says nothing that is not so."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import pytest

from shared.messages import ControlStatus, EndEffector, RobotStatus
from shared.schema.records import Record
from shared.topics import CONTROL_STATUS, CONTROL_TARGET, STATE_EE, STATE_ROBOT, Topic
from tests.conftest import Router, StartProcess
from tests.services.cli.command import tandem
from tests.shared.rig import target
from tests.support.processes import Process
from tests.support.stand_in import StandIn
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

POSE = ("0.5", "-0.3", "1", "0", "0", "0")
ZERO3, ZERO6, LEVEL = (0.0,) * 3, (0.0,) * 6, (0.0, 0.0, 0.0, 1.0)
STATUS = ControlStatus("tracking", "", "certified", *[ZERO6] * 3, 0.0, 0.0, 50.0)
ROBOT: tuple[tuple[Topic, Record], ...] = (
    (STATE_EE, EndEffector((0.5, -0.3, 1.0), LEVEL, ZERO3, ZERO3)),
    (STATE_ROBOT, RobotStatus("ready", "", "omni", False, 0.3, 1.0, (1.0, 1.0, 2.0))),
    (CONTROL_STATUS, STATUS),
)


def holding(start: StartProcess, endpoint: str) -> Process:
    process = start("services.cli", "hold", *POSE, "--connect", endpoint)
    process.wait_for_output("asking for")
    return process


def test_a_second_hold_or_identify_ends_at_once_and_the_first_one_goes_on(router: Router, start: StartProcess) -> None:
    with StandIn(router.endpoint, "controller", lambda number: ROBOT):
        first = holding(start, router.endpoint)
        first.wait_for_output("controller: law certified, tracking")
        for command in (("hold", *POSE), ("identify", "--yes")):
            done = tandem(*command, "--connect", router.endpoint)
            assert done.returncode == 1 and "asking for" not in done.stdout and "pose 1" not in done.stdout
            assert "hold publishes control/target and was first" in done.stderr and "Ctrl-C" in done.stderr
        assert first.running
        first.signal(signal.SIGSTOP)
        time.sleep(1.2)  # longer than a publisher may be silent without losing its place
        second = holding(start, router.endpoint)
        first.signal(signal.SIGCONT)
        assert first.wait() == 1 and "hold publishes control/target and was first" in first.output
        second.signal(signal.SIGINT)
        assert second.wait() == 0 and "the last target stays in force" in second.output


def test_a_hold_that_nobody_follows_does_not_say_that_it_holds(router: Router, start: StartProcess) -> None:
    alone = holding(start, router.endpoint)
    alone.wait_for_output("control/status: never received")
    alone.signal(signal.SIGINT)
    assert alone.wait() == 0
    assert "nothing is held" in alone.output and "stays in force" not in alone.output


def test_an_experiment_is_not_played_beside_somebody_elses_target(
    router: Router, start: StartProcess, tmp_path: Path
) -> None:
    says = lambda number: [(CONTROL_TARGET, target())] if number % 20 == 0 else []  # noqa: E731
    with StandIn(router.endpoint, "controller", says) as other:
        other.bus.claim("task", other.client.publisher.session)
        play = ("play", "load", "--run", "certified-100", "--out", str(tmp_path), "--connect", router.endpoint)
        process = start("services.experiment", *play)
        assert process.wait(20.0) == 1
        assert "task publishes control/target and was first" in process.output


def test_a_real_robot_is_not_missed_as_a_simulated_one_and_what_is_refused_is_said(router: Router) -> None:
    with StandIn(router.endpoint, "robot", lambda number: ROBOT) as robot:
        robot.bus.alive("robot", robot.client.publisher.session)
        robot.spoil[STATE_EE.key] = lambda payload: (b"?",)
        eventually(lambda: robot.turns > 10)
        done = tandem("status", "--connect", router.endpoint)
        assert done.returncode == 1 and "start sim" not in done.stdout, done.stdout
        assert "wrong: state/ee: " in done.stdout and "messages rejected, the last one: " in done.stdout
        done = tandem("topic", "hz", "--connect", router.endpoint)
        assert "messages rejected, the last one: " in done.stdout
        done = tandem("topic", "echo", "state/ee", "--within", "0.5", "--connect", router.endpoint)
        assert done.returncode == 1 and "messages rejected, the last one: " in done.stderr
