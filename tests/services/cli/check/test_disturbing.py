"""What a person does to the robot's process while the tool sways is judged by where the tool is afterwards."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from services.cli.check import disturbing
from services.cli.check.bench import Bench
from services.cli.check.disturbing import Disturbances
from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.clock import nanoseconds
from shared.loop.stack import Stack
from shared.messages import Stop
from shared.service import Inputs, Output
from shared.topics import STATE_ROBOT, STOP


class Far(MockRobot):
    """A bridge, as far as this is about: its robot may be cut off, and what it does then can be wrong.

    Attributes:
        cut: whether it is; a bridge latches a stop then.
        latches: whether this one does.
        keeps: whether the stop stays when the robot is there again.
    """

    cut, latches, keeps = False, True, True

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        if self.cut and self.latches:
            self.side.gate.stop(True, "joint states are silent")
        elif self.side.gate.mode == "stopped" and not self.keeps:
            self.side.gate.stop(False, "")
        outputs = [
            replace(output, message=output.message.replaced(simulated=False)) if output.topic is STATE_ROBOT else output
            for output in super().step(inputs, dt)
        ]
        return [output for output in outputs if output.topic is STATE_ROBOT] if self.cut else outputs


class Rig:
    """A robot on the bench, and a person who does what is said by what ``acts`` has for it."""

    def __init__(self) -> None:
        self.stack = Stack(latency=0.001)
        self.robot = Far(MockParameters())
        self.runner = self.stack.add(self.robot)
        self.bench = Bench(self.stack.bus, self.stack.scheduler.clock, self.stack.run)
        self.said: list[str] = []
        self.acts: dict[str, Callable[[], None]] = {}

    def later(self, after: float, action: Callable[[], None]) -> None:
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(after), action)

    def say(self, text: str) -> None:
        self.said.append(text)
        for words, action in self.acts.items():
            if words in text:
                action()

    def result(self, name: str) -> tuple[bool | None, str]:
        self.bench.wait(0.5)
        (row,) = Disturbances(self.bench, self.bench.commander(), self.say).rows([name])
        return row.good, row.said

    def restart(self, gone_on: float = 0.0) -> None:
        """Kill it, and start another one where it was, or farther on [m]."""
        self.later(1.0, lambda: self.stack.kill(self.runner))

        def again() -> None:
            robot = Far(MockParameters())
            robot.motors.position = self.robot.motors.position - np.array((0.0, 0.0, gone_on))
            self.runner = self.stack.add(robot)

        self.later(3.0, again)

    def release(self) -> None:
        self.later(0.5, lambda: self.stack.client.publish(STOP, Stop(False, "tandem resume")))

    def cut(self) -> None:
        self.robot.cut = True

    def join(self) -> None:
        self.robot.cut = False


@pytest.mark.parametrize("name", ["restarted", "killed", "hung"])
@pytest.mark.parametrize(("gone_on", "good"), [(0.0, True), (0.03, False)])
def test_how_far_the_tool_goes_on_without_its_process_is_judged(name: str, gone_on: float, good: bool) -> None:
    rig = Rig()
    rig.acts = {"The tool sways": lambda: rig.restart(gone_on)}
    found, said = rig.result(name)
    assert found == good, said
    assert good or ("the tool went on by" in said and "has to end at rest within 0.25 s" in said)


def test_nobody_does_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disturbing, "ASKED_WITHIN", 3.0)
    rig = Rig()
    assert rig.result("killed") == (False, "not tried: state/ee never fell silent within 3 s")
    rig.acts = {"The tool sways": lambda: rig.later(1.0, lambda: rig.stack.kill(rig.runner))}
    assert rig.result("killed") == (False, "it did not come back within 3 s")


def silenced(latches: bool = True, keeps: bool = True) -> tuple[bool | None, str]:
    rig = Rig()
    rig.robot.latches, rig.robot.keeps = latches, keeps
    rig.acts = {"The tool sways": rig.cut, "join them again": rig.join, "Release it: tandem": rig.release}
    return rig.result("silent")


def test_a_robot_that_falls_silent_latches_a_stop_until_a_person_releases_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disturbing, "ASKED_WITHIN", 10.0)
    assert silenced() == (True, "latched a stop, and nothing resumed")
    good, said = silenced(latches=False)
    assert not good and "no stop was latched" in said
    good, said = silenced(keeps=False)
    assert not good and said == "the tool moves although a stop was latched and nobody released it"
