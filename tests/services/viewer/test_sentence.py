"""The sentence on top: every kind of reason that somebody can state, what is old, and nothing that nobody said."""

from __future__ import annotations

import numpy as np
import pytest

from services.viewer.sentence import LONGEST, Kind, Known, say, used_share
from shared.topics import CONTROL_STATUS, STATE_ROBOT, TASK_STATUS, health_topic
from tests.services.viewer.known import LIMIT, at, control, health, known, robot, task


def without(heard: Known, *keys: str) -> Known:
    return {key: told for key, told in heard.items() if key not in keys}


CASES: dict[str, tuple[Known, Kind, str]] = {
    "nothing holds it back": (known(), Kind.FREE, "nothing holds it back; nearest: torque x, 0.2 Nm left"),
    "no limits are told": (known(control(limit=None)), Kind.FREE, "nothing holds it back"),
    "a limit": (
        known(control("yielding", **at(2, -1.0, 24.8))),
        Kind.HELD,
        "held back by z force: 24.8 of 25 N",
    ),
    "a torque": (known(control("yielding", **at(3, 1.0, 0.48))), Kind.HELD, "held back by torque x: 0.48 of 0.5 Nm"),
    "two limits": (
        known(control("yielding", **at(0, 1.0, 9.9, (4, -1.0, 2.9)))),
        Kind.HELD,
        "held back by x force: 9.9 of 10 N and torque y: 2.9 of 3 Nm",
    ),
    "a limit that is passed": (
        known(control("yielding", **at(1, 1.0, 10.4))),
        Kind.HELD,
        "held back by y force: 10.4 of 10 N",
    ),
    "a limit that is passed by a law that does not mind": (
        known(control(margin=np.array((9.0, 8.0, 20.0, -0.04, 2.5, 2.0)))),
        Kind.HELD,
        "past a limit, and not held back: torque x: 0.54 of 0.5 Nm",
    ),
    "a limit before anything is felt": (
        known(control("tracking", **at(0, 1.0, 0.4))),
        Kind.HELD,
        "held back by x force: 0.4 of 10 N (as a precaution)",
    ),
    "a limit whose size is not told": (
        known(control("yielding", **{**at(0, 1.0, 9.75), "limit": None})),
        Kind.HELD,
        "held back by x force: 0.2 N left",
    ),
    "it yields before a limit": (
        known(control("yielding", margin=np.array((9.0, 8.0, 4.9, 0.4, 2.5, 2.0)))),
        Kind.HELD,
        "giving way to z force: 20.1 of 25 N",
    ),
    "the controller waits": (
        known(control("waiting", "no valid control/target yet")),
        Kind.WAITING,
        "waiting: no valid control/target yet",
    ),
    "the controller waits for a topic": (
        known(control("waiting", "waiting for wrench/external: never received. Is wrench running?")),
        Kind.WAITING,
        "waiting for wrench/external: never received. Is wrench running?",
    ),
    "the controller brakes": (
        known(control("braking", "wrench/external is 80 ms old, allowed are 30 ms. Is wrench running?")),
        Kind.STOPPED,
        "braking: wrench/external is 80 ms old, allowed are 30 ms. Is wrench running?",
    ),
    "it brakes without a word": (known(control("braking")), Kind.STOPPED, "braking"),
    "a stop": (
        known(robot("stopped", "stop engaged: hand in the way. Release it with `tandem resume`")),
        Kind.STOPPED,
        "stopped: hand in the way. Release it with `tandem resume`",
    ),
    "nobody could stop it": (
        known(robot("holding", "nobody could stop the robot: the router is gone")),
        Kind.STOPPED,
        "the robot executes nothing: nobody could stop the robot: the router is gone",
    ),
    "the robot holds without a word": (
        known(robot("holding")),
        Kind.STOPPED,
        "the robot executes nothing: it does not say why",
    ),
    "the robot cannot": (
        known(robot("ready", "arm_right_4_joint is at its upper limit; commands late: 3")),
        Kind.HELD,
        "held back by the robot itself: arm_right_4_joint is at its upper limit",
    ),
    "what was counted explains nothing": (
        known(robot("ready", "commands clamped: 3; base commands clamped: 2 (last: vx)")),
        Kind.FREE,
        "nothing holds it back; nearest: torque x, 0.2 Nm left",
    ),
    "the marker is covered": (
        known(task("approaching", "waiting: no marker in sight: is it covered, or out of the picture?")),
        Kind.WAITING,
        "waiting: no marker in sight: is it covered, or out of the picture?",
    ),
    "the marker is looked for": (
        known(task("searching", "no marker in sight: is it covered, or out of the picture?")),
        Kind.WAITING,
        "the task is searching: no marker in sight: is it covered, or out of the picture?",
    ),
    "the task holds": (
        known(task("holding", "the gripper does not open: look at it")),
        Kind.WAITING,
        "the task holds: the gripper does not open: look at it",
    ),
    "the task works": (
        known(task("carrying", "lift the panel")),
        Kind.FREE,
        "nothing holds it back; nearest: torque x, 0.2 Nm left",
    ),
    "no controller": (
        without(known(), CONTROL_STATUS.key),
        Kind.LOST,
        "no answer from controller: nothing was heard on control/status",
    ),
    "a controller that starts": (
        without(known(controller=health("starting", "inputs are healthy, starting in 0.3 s")), CONTROL_STATUS.key),
        Kind.LOST,
        "controller is starting: inputs are healthy, starting in 0.3 s",
    ),
    "a controller that is well and not heard yet": (
        without(known(controller=health()), CONTROL_STATUS.key),
        Kind.LOST,
        "no answer from controller: nothing was heard on control/status",
    ),
    "a controller that is gone": (
        known(ages={CONTROL_STATUS.key: 2.3}),
        Kind.LOST,
        "no answer from controller for 2 s: what is shown of it is old",
    ),
    "a robot that is gone": (
        known(robot("stopped", "stop engaged: x"), ages={STATE_ROBOT.key: 300.0}),
        Kind.LOST,
        "no answer from the robot for 5 min: what is shown of it is old",
    ),
    "no robot": (
        without(known(), STATE_ROBOT.key),
        Kind.LOST,
        "no answer from the robot: nothing was heard on state/robot",
    ),
    "a task that is gone at work": (
        known(task("carrying", "carrying"), ages={TASK_STATUS.key: 4.0}),
        Kind.LOST,
        "no answer from task for 4 s: what is shown of it is old",
    ),
    "a task that had ended": (
        known(task("done", "the panel was set down"), ages={TASK_STATUS.key: 4.0}),
        Kind.FREE,
        "nothing holds it back; nearest: torque x, 0.2 Nm left",
    ),
    "nothing at all": ({}, Kind.LOST, "nothing is heard of the robot: `tandem up` starts one"),
}


@pytest.mark.parametrize("case", CASES)
def test_it_says_why(case: str) -> None:
    heard, kind, text = CASES[case]
    assert say(heard)[:2] == (text, kind)


def test_every_kind_is_said_somewhere() -> None:
    assert {kind for _, kind, _ in CASES.values()} == set(Kind)


def test_a_stop_comes_before_what_it_causes_and_nothing_is_lost() -> None:
    stop = "stop engaged: hand in the way. Release it with `tandem resume`"
    said = say(known(robot("stopped", stop), control("braking", stop), task("holding", "stop is engaged")))
    assert said.text == "stopped: hand in the way. Release it with `tandem resume`"
    assert f"braking: {stop}" in said.more and "the task holds: stop is engaged" in said.more


def test_who_is_silent_comes_before_all_that_it_said() -> None:
    said = say(known(control("yielding", **at(2, 1.0, 24.8)), task("carrying"), ages={CONTROL_STATUS.key: 9.0}))
    assert said.kind is Kind.LOST and "held back" not in " ".join((said.text, *said.more))


def test_without_a_router_everything_is_old() -> None:
    said = say(known(control("yielding", **at(2, 1.0, 24.8))), "no router at tcp/127.0.0.1:7447")
    assert said == ("no router at tcp/127.0.0.1:7447: what is shown is old", Kind.LOST, ())


def test_more_is_what_controller_task_and_health_say_besides() -> None:
    pending = "limit z: 30 N in force, 25 wished"
    said = say(
        known(
            control("tracking", pending),
            task("carrying", "lift the panel: the robot carries 0.4 of 7.4 N"),
            wrench=health("degraded", "the sensor is stuck: mend it"),
            base=health("fault"),
            sim=health(),
            ages={health_topic("base").key: 0.5},
        )
    )
    assert said.more == (
        f"controller: {pending}",
        "task carrying: lift the panel: the robot carries 0.4 of 7.4 N",
        "wrench is degraded: the sensor is stuck: mend it",
        "base is fault",
    )


def test_a_health_that_is_old_is_no_health() -> None:
    said = say(known(wrench=health(), ages={health_topic("wrench").key: 6.0}))
    assert said.more == ("wrench says nothing since 6 s",)


def test_nothing_is_said_twice_and_nothing_is_longer_than_a_line() -> None:
    said = say(known(control("braking", "x" * 3000), task("approaching", "waiting: a\nb")))
    assert len(said.text) == LONGEST and said.text.endswith("...")
    assert all("\n" not in line for line in (said.text, *said.more))
    assert say(known(task("approaching", "waiting: no marker"))).more == ()
    said = say(known(control("braking", "a stop"), task("searching", "it looks around")))
    assert said.more == ("the task is searching: it looks around",)


def test_the_share_of_a_limit_counts_force_and_error_bound() -> None:
    status = control("yielding", **at(2, 1.0, 20.0))
    assert used_share(status)[2] == pytest.approx(0.8)
    assert np.isnan(used_share(control(limit=None))).all()
    part = LIMIT.copy()
    part[0] = 0.0
    assert np.isnan(used_share(control(limit=part))[0]) and used_share(control(limit=part))[1] == pytest.approx(0.2)
