"""The contact world as a robot that speaks the contract in real time, behind the real gate.

It publishes `sensor/ft`, `state/ee` and `state/robot`, takes `command/ee_twist` through ``shared.limits.Gate``, and
plays the experiment's part too (`control/target`). It knows the true wrench, so that is what it judges, and it
measures whether the declared times held.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field

import numpy as np

from benchmarks.contact.cases import Case
from benchmarks.contact.robot import Robot
from benchmarks.contact.world import World
from shared.client import Client
from shared.inlet import Received
from shared.limits import Gate, GateLimits
from shared.messages import ControlTarget, EndEffector, FtSample, RobotStatus, TwistCommand
from shared.spatial import quaternion
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, SENSOR_FT, STATE_EE, STATE_ROBOT

TICK = 0.002
"""The robot's own period [s]."""
_LONGEST_TICK = 0.005
"""Where this process itself is late, the robot's time stands still [s]; a robot's servo loop is never that late."""


@dataclass
class Measured:
    """What happened in one case.

    Attributes:
        peak: largest abs(true wrench - nominal)/limit.
        travelled: of the tool origin [m].
        held: longest time for which one command was executed [s].
        delays: of each command, from its sample being sent to its being executed [s].
        stalls: how often this process was late, so that the robot's time stood still.
        moved: whether any command was executed at all.
    """

    peak: float = 0.0
    travelled: float = 0.0
    held: float = 0.0
    delays: list[float] = field(default_factory=list)
    stalls: int = 0
    moved: bool = False

    @property
    def delay(self) -> float:
        """Longest delay [s]."""
        return max(self.delays, default=0.0)


class LiveRobot:
    """One robot on the bus, to be put into one case after the other."""

    def __init__(self, client: Client, sample_rate: float) -> None:
        self._client = client
        self._every = max(1, round(1.0 / (sample_rate * TICK)))
        self._lock = threading.Lock()
        self._arrived: Received[TwistCommand] | None = None
        client.watch(COMMAND_EE_TWIST, self._arrive)

    def _arrive(self, command: Received[TwistCommand]) -> None:
        with self._lock:
            self._arrived = command

    def play(self, case: Case, patience: float) -> Measured:
        """Runs ``case`` in real time, from the first command that moves the robot, at most ``patience`` [s] later."""
        robot = Robot(case.position.copy(), case.rotation.copy(), 0.0)
        world = World(case.contacts, robot.position, robot.rotation)
        gate = Gate(GateLimits(case.declared.max_linear * 2.0, case.declared.max_angular * 2.0, 1e3, 1e3))
        found, log = Measured(), _Log()
        rng = np.random.default_rng(case.seed)
        wrench = world.advance(robot.position[None], robot.rotation[None], np.zeros((1, 3)))[0]
        bias = case.error_bound * rng.uniform(-0.5, 0.5, 6)
        before, began = time.monotonic(), time.monotonic()
        now, tick = 0.0, 0
        while now < case.duration and (found.moved or time.monotonic() - began < patience):
            if tick % self._every == 0:
                error = bias + case.error_bound * rng.uniform(-0.5, 0.5, 6)
                self._publish(case, robot, wrench + error, now, tick)
                log.sampled(time.monotonic())
            self._take(gate, log)
            # The tick that follows is executed with this twist, whatever arrives meanwhile.
            time.sleep(max(0.0, before + TICK - time.monotonic()))
            elapsed, before = time.monotonic() - before, time.monotonic()
            found.stalls += elapsed > _LONGEST_TICK
            dt = min(elapsed, _LONGEST_TICK)
            twist = gate.advance(dt)
            found.moved |= bool(twist.any())
            log.executed(bool(twist.any()), dt)
            robot.command(now, twist, dt + 1.0)
            path = robot.advance(now, now + dt, dt / 8.0)
            wrenches = world.advance(path.positions, path.rotations, np.zeros((len(path.times), 3)))
            wrench = wrenches[-1]
            found.peak = max(found.peak, float((np.abs(wrenches - case.nominal) / case.limit).max()))
            now += dt if found.moved else 0.0
            tick += 1
        found.travelled = float(robot.travelled[0])
        found.held, found.delays = log.held, log.delays()
        return found

    def _take(self, gate: Gate, log: _Log) -> None:
        with self._lock:
            command, self._arrived = self._arrived, None
        if command is not None:
            message = command.message
            gate.command(message.linear, message.angular, message.ttl, command.delay, command.header.valid)
            log.commanded(command.number, time.monotonic())

    def _publish(self, case: Case, robot: Robot, wrench: np.ndarray, now: float, tick: int) -> None:
        turn = robot.rotation.T
        attitude = quaternion(robot.rotation)
        twist = robot.twist
        sample = FtSample(turn @ wrench[:3], turn @ wrench[3:], attitude, np.zeros(3), False)
        self._client.publish(STATE_EE, EndEffector(robot.position, attitude, twist[:3], twist[3:]))
        self._client.publish(SENSOR_FT, sample)
        if tick % (self._every * 10) == 0:
            fastest = case.declared.max_linear * 2.0, case.declared.max_angular * 2.0
            self._client.publish(STATE_ROBOT, RobotStatus("ready", "", "omni", True, *fastest, np.ones(3)))
            target = case.target(now)
            limits = case.limit[:3], case.limit[3:], case.nominal[:3], case.nominal[3:]
            pose = target.position, quaternion(target.rotation)
            self._client.publish(CONTROL_TARGET, ControlTarget(*pose, *limits))


class _Log:
    """When samples left and commands were executed, to find how long each took."""

    def __init__(self) -> None:
        self.held = 0.0
        self._holding = 0.0
        self._sent: list[float] = []
        self._taken: list[tuple[int, float, int]] = []

    def sampled(self, now: float) -> None:
        """A sample leaves."""
        self._sent.append(now)

    def commanded(self, number: int, now: float) -> None:
        """Command ``number`` is taken over, when ``len(self._sent)`` samples have left."""
        self._taken.append((number, now, len(self._sent)))
        self._holding = 0.0

    def executed(self, moving: bool, dt: float) -> None:
        """The gate lets the newest command through, or nothing, for ``dt`` [s]."""
        self._holding = self._holding + dt if moving else 0.0
        self.held = max(self.held, self._holding)

    def delays(self, window: int = 50) -> list[float]:
        """Delay [s] of each command from its sample.

        Every sample gives one command, so sample and command numbers differ by a constant, which grows where one is
        lost. The least difference among the next ``window`` commands is taken for it: at that one nothing was waiting.
        """
        ahead = [sent - number for number, _, sent in self._taken]
        found = []
        for index, (number, taken, _) in enumerate(self._taken):
            sample = number + min(ahead[index : index + window])
            if 0 < sample <= len(self._sent):
                found.append(taken - self._sent[sample - 1])
        return found
