"""One sensor before the real wrench service, in simulated time: every stated sample is held against the truth."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.honest import evidence
from benchmarks.honest.sensor import DOWN, TOOL_OFFSET, Sensor
from benchmarks.honest.verdict import TOLERANCE, Verdict
from services.wrench.parameters import WrenchParameters
from services.wrench.wrench import Wrench
from shared.clock import nanoseconds
from shared.loop.runner import Runner
from shared.loop.stack import Stack
from shared.messages import ExternalWrench, FtSample
from shared.parameters import Refused
from shared.spatial import (
    Array,
    quaternion,
    quaternion_from_rpy,
    quaternion_from_vector,
    rotation_from_vector,
    rotation_matrix,
)
from shared.topics import SENSOR_FT, WRENCH_EXTERNAL, WRENCH_IDENTIFY, WRENCH_TARE
from shared.wire.client import Client
from shared.wire.subscription import Received

NAMES = ("fx", "fy", "fz", "tx", "ty", "tz")
SLACK = 1e-6  # [N, Nm] of rounding
SEGMENT = 0.3  # [s] of each push and each pause
STUCK_WITHIN = 0.1  # [s] of which docs/faults.md promises that a frozen axis is known after it
SETTLED = 1.5  # [s] after a start in which a sensor may still be found to live

HIDDEN = "an average that a declared bias and tool explain as well; that nothing touches the tool is the person's word"
UNCALIBRATED = "nothing was tared: no reading contradicts the declared bias, a touch explains every one"


@dataclass
class Case:
    """A sensor, what is declared of it, and what happens to it.

    Attributes:
        declared: parameters that differ from the defaults.
        how: "tare", "identify", or nothing, as with a payload file.
        sound: whether everything is as declared.
        touch: wrench (6,) [N, Nm] on the tool during the calibration, base axes.
        slope: true direction of gravity (3,) at the calibration, base axes.
        told: whether the robot says where down is.
        rate: of the samples [Hz].
        then: what happens after the first use.
        lulls: whether each change of what acts may let an axis repeat one value, of which nobody knows at once.
        excuse: why what is false here is outside of all that is declared; None: the readings decide.
    """

    sensor: Sensor
    declared: dict[str, Any] = field(default_factory=dict)
    how: str = "tare"
    sound: bool = True
    touch: Array = field(default_factory=lambda: np.zeros(6))
    slope: Array = field(default_factory=lambda: DOWN.copy())
    told: bool = False
    rate: float = 100.0
    then: Callable[[Trial], None] = lambda trial: None
    lulls: bool = False
    excuse: str | None = None


class Trial:
    """Drives the case. What happens to it (`then`) may change everything.

    Attributes:
        rotation: sensor in base (3, 3).
        external: true wrench (6,) on the tool, base axes.
        gravity: its true direction (3,), base axes.
        excuse: why what is false now is outside of what was declared; empty if it is not.
    """

    def __init__(self, case: Case, random: np.random.Generator, folder: Path, service: type[Wrench] = Wrench) -> None:
        self.case, self.random, self.sensor = case, random, case.sensor
        self._folder, self._service = folder, service
        self.stack = Stack()
        # Along the axes of base a bound is tightest: that is where half of them are.
        quarters = random.integers(-1, 3, 3) * np.pi / 2
        turn = random.uniform(-1.5, 1.5, 3)
        self.rotation = self.home = rotation_matrix(
            quaternion_from_rpy(*quarters) if random.random() < 0.5 else quaternion_from_vector(turn)
        )
        self.external: Array = np.zeros(6)
        self.gravity = case.slope
        self.excuse = "" if case.sound else UNCALIBRATED
        self.refused = self.false = self.outside = ""
        self.published = True
        self._worst = 1.0
        self._excused_until = self._started = 0.0
        self._number = 0
        self._truth = self.external
        self._sent: FtSample | None = None
        self._averages: list[tuple[Array, Array]] | None = None
        declared = {name: value(folder) if callable(value) else value for name, value in case.declared.items()}
        self.parameters = WrenchParameters.of(declared)
        self.new_session()
        self.stack.client.watch(WRENCH_EXTERNAL, self._judge)
        self.start_service()
        self._tick()

    def new_session(self) -> None:
        """The robot process is started anew."""
        self.robot = Client(self.stack.bus, self.stack.scheduler.clock)

    def start_service(self) -> None:
        """The wrench service is started."""
        self._started = self.stack.now
        self.runner: Runner = self.stack.add(self._service(self.parameters, self._folder))

    def resume(self) -> None:
        """The robot process publishes again."""
        self.published, self._started = True, self.stack.now

    def kill_service(self) -> None:
        """It says nothing any more, and hears nothing."""
        self.stack.kill(self.runner)
        self.stack.bus._subscribers.pop(SENSOR_FT.key)

    def _tick(self) -> None:
        self.stack.scheduler.at(self.stack.scheduler.clock.now_ns() + nanoseconds(1.0 / self.case.rate), self._tick)
        if not self.published:
            return
        if self._sent is None or self._number % self.sensor.repeats == 0:
            self._sent, self._truth = self._sample(), self.external
        self._number += 1
        self.robot.publish(SENSOR_FT, self._sent)

    def _sample(self) -> FtSample:
        sensor, before = self.sensor, self._sent
        exact = sensor.exact(self.rotation, self.gravity, self.external)
        raw, ended = sensor.reading(exact, self.rotation, self.stack.now / 60.0, self._number, self.random)
        if before is not None and sensor.frozen:
            axes = list(sensor.frozen)
            raw[axes] = np.concatenate((before.force, before.torque))[axes]
        if self._averages is not None:
            self._averages.append((raw, self.rotation))
        told = {"gravity": self.gravity} if self.case.told else {}
        return FtSample(raw[:3], raw[3:], quaternion(self.rotation), TOOL_OFFSET, ended, **told)

    def _judge(self, received: Received[ExternalWrench]) -> None:
        message = received.message
        if not received.header.valid or message.fault:
            if self.stack.now > self._started + SETTLED and not self.refused and self.published:
                self.refused = f"the sensor is {message.fault or 'not valid'}"
            return
        if self.stack.now < self._excused_until:
            return
        stated = np.concatenate((message.force, message.torque))
        error, bound = np.abs(stated - self._truth), message.error_bound
        axis = int(np.argmax(error / (bound + SLACK)))
        ratio = float(error[axis] / (TOLERANCE * bound[axis] + SLACK))
        if ratio <= self._worst:
            return
        # The worst of what nobody excuses counts; of what is outside only if there is nothing else.
        text = (
            f"{NAMES[axis]} {stated[axis]:.2f} ± {bound[axis]:.2f}, true {self._truth[axis]:.2f}, "
            f"{message.compensation} at {self.stack.now:.1f} s"
        )
        if self.excuse:
            self.outside = self.outside or f"{text}: {self.excuse}"
        else:
            self._worst, self.false = ratio, text

    def run(self, duration: float) -> None:
        """Let time [s] pass."""
        self.stack.run(duration)

    def push(self, external: Array, duration: float = SEGMENT) -> None:
        """Something acts on the tool for a while; nothing does afterwards."""
        self._changed()
        self.external = external
        self.run(duration)
        self._changed()
        self.external = np.zeros(6)
        self.run(0.05)

    def _changed(self) -> None:
        if self.case.lulls:
            self.unseen()

    @property
    def weight(self) -> Array:
        """The tool's part (6,) in what acts on the sensor now, in its axes."""
        return self.sensor.exact(self.rotation, self.gravity, np.zeros(6))

    def some_push(self, force: float = 30.0, torque: float = 1.5) -> Array:
        """A wrench (6,) of at most that [N, Nm]."""
        return np.concatenate((self._within(force), self._within(torque)))

    def _within(self, size: float) -> Array:
        direction = self.random.standard_normal(3)
        return direction / np.linalg.norm(direction) * size * self.random.uniform(0.2, 1.0)

    def turned(self, angle: float) -> Array:
        """The sensor turned by an angle [rad] about some axis (3, 3)."""
        axis = self.random.standard_normal(3)
        return rotation_from_vector(angle * axis / np.linalg.norm(axis)) @ self.home

    def use(self) -> None:
        """The robot works: free, pushed, turned, and both."""
        self.run(SEGMENT)
        self.push(self.some_push())
        self.rotation = self.turned(self.random.uniform(0.1, 1.4))
        self._changed()
        self.run(SEGMENT)
        self.push(self.some_push())
        self.rotation = self.home
        self._changed()
        self.run(0.1)

    def freeze(self, *axes: int) -> None:
        """Axes keep their last value from now on."""
        self.sensor.frozen = axes
        self.unseen()

    def unseen(self) -> None:
        """An axis that repeats one value from now on need not be known before `STUCK_WITHIN`."""
        self._excused_until = self.stack.now + STUCK_WITHIN + 1.0 / self.case.rate

    def wait(self, minutes: float) -> None:
        """Nothing happens for minutes."""
        self.run(60.0 * minutes)

    def calibrate(self, how: str, touch: Array | None = None) -> bool:
        """Tare or identify while something touches the tool, or nothing; whether that was accepted."""
        self.external = np.zeros(6) if touch is None else touch
        self.run(0.1)
        self._averages = []
        try:
            readings = self._identify() if how == "identify" else self._tare()
        except Refused as refusal:
            self.refused = self.refused or str(refusal)
            return False
        finally:
            self._averages = None
            self.external, self.rotation = np.zeros(6), self.home
        self.run(0.0)  # what was stated before is judged as that
        if not self.case.sound:
            self.excuse = self._excuse(how, readings)
        self.run(0.05)
        return True

    def _tare(self) -> list[tuple[Array, Array]]:
        self._ask(WRENCH_TARE, {"duration": 0.5})
        return list(self._averages or [])

    def _identify(self) -> list[tuple[Array, Array]]:
        self._ask(WRENCH_IDENTIFY, {"action": "start"})
        readings: list[tuple[Array, Array]] = []
        turns = [(0.0, 0.0, 0.0), *self.random.uniform(0.5, 0.9, (6, 3)) * _SIGNS]
        for turn in turns:
            self.rotation = self.home @ rotation_from_vector(turn)
            self.run(0.1)
            self._averages = []
            self._ask(WRENCH_IDENTIFY, {"action": "add", "duration": 0.3})
            readings += self._averages
        self._ask(WRENCH_IDENTIFY, {"action": "solve"})
        return readings

    def _ask(self, query: Any, request: dict[str, Any]) -> None:
        self.stack.client.ask(query, request, timeout=5.0)

    def _excuse(self, how: str, readings: list[tuple[Array, Array]]) -> str:
        if self.case.excuse is not None:
            return self.case.excuse
        possible = evidence.possible(how, readings, self.sensor, self.parameters)
        return HIDDEN if possible else ""


_SIGNS = np.array(((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 1, 0), (-1, 0, 1)))


def play(kind: str, seed: int, case: Case, random: np.random.Generator, service: type[Wrench] = Wrench) -> Verdict:
    """The verdict on one case."""
    with tempfile.TemporaryDirectory() as folder:
        trial = Trial(case, random, Path(folder), service)
        trial.run(0.5)
        accepted = case.how == "nothing" or trial.calibrate(case.how, case.touch)
        trial.use()
        if accepted:
            case.then(trial)
    return Verdict(kind, seed, trial.case.sound, trial.refused, trial.false, trial.outside)
