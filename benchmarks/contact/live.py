"""The contact world as a robot that speaks the contract in real time, behind the real gate.

It publishes `sensor/ft`, `state/ee` and `state/robot`, takes `command/ee_twist` through ``shared.robot.gate.Gate``, and
plays the experiment's part too (`control/target`). It knows the true wrench, so that is what it judges, and it
measures whether the declared times held.
"""

from __future__ import annotations

import time
from bisect import bisect_left
from dataclasses import dataclass, field

import numpy as np

from benchmarks.contact.cases import Case
from benchmarks.contact.robot import Robot
from benchmarks.contact.world import World
from shared.messages import ControlTarget, EndEffector, FtSample, RobotStatus, TwistCommand
from shared.robot.gate import Gate, GateLimits
from shared.spatial import Array, quaternion
from shared.topics import COMMAND_EE_TWIST, CONTROL_TARGET, SENSOR_FT, STATE_EE, STATE_ROBOT, WRENCH_EXTERNAL
from shared.wire.client import Client
from shared.wire.subscription import Received

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
        self._commands = client.watch(COMMAND_EE_TWIST)
        self._taken: Received[TwistCommand] | None = None
        self._wrenches: list[float] = []
        client.watch(WRENCH_EXTERNAL, lambda wrench: self._wrenches.append(wrench.header.stamp * 1e-9))

    def play(self, case: Case, patience: float) -> Measured:
        """Runs ``case`` in real time, from the first command that moves the robot, at most ``patience`` [s] later."""
        robot = Robot(case.position.copy(), case.rotation.copy(), 0.0)
        world = World(case.contacts, robot.position, robot.rotation)
        gate = Gate(GateLimits(case.declared.max_linear * 2.0, case.declared.max_angular * 2.0, 1e3, 1e3))
        found, log = Measured(), _Log(self._wrenches)
        self._wrenches.clear()
        rng = np.random.default_rng(case.seed)
        wrench = world.advance(robot.position[None], robot.rotation[None], np.zeros((1, 3)))[0]
        bias = case.error_bound * rng.uniform(-0.5, 0.5, 6)
        before, began = time.monotonic(), time.monotonic()
        now, tick = 0.0, 0
        while now < case.duration and (found.moved or time.monotonic() - began < patience):
            if tick % self._every == 0:
                error = bias + case.error_bound * rng.uniform(-0.5, 0.5, 6)
                self._publish(case, robot, wrench + error, now, tick)
                log.sent.append(time.monotonic())
            self._take(gate, log)
            # The tick that follows is executed with this twist, whatever arrives meanwhile.
            time.sleep(max(0.0, before + TICK - time.monotonic()))
            elapsed, before = time.monotonic() - before, time.monotonic()
            found.stalls += elapsed > _LONGEST_TICK
            dt = min(elapsed, _LONGEST_TICK)
            twist = gate.advance(dt)
            found.moved |= bool(twist.any())
            log.executed(twist, dt)
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
        command = self._commands.latest
        if command is not None and command is not self._taken:
            self._taken, message = command, command.message
            gate.command(message.linear, message.angular, message.ttl, command.delay, command.header.valid)
            wanted = np.concatenate((message.linear, message.angular))
            log.commanded(command.header.stamp * 1e-9, wanted, time.monotonic())

    def _publish(self, case: Case, robot: Robot, wrench: Array, now: float, tick: int) -> None:
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
    """When samples left and commands were executed, to find how long each took.

    All processes of a run share one steady clock, so their stamps can be compared: a command was made from the newest
    wrench before its stamp, and that from the newest sample before the wrench's. What was still on its way to the next
    process then is not seen, so a delay is what was measured or more.

    Attributes:
        held: longest time for which one command was executed [s].
        sent: when each sample left [s].
    """

    def __init__(self, wrenches: list[float]) -> None:
        self.held = 0.0
        self._holding = 0.0
        self._wanted = np.zeros(6)
        self.sent: list[float] = []
        self._wrenches = wrenches
        self._taken: list[tuple[float, float]] = []

    def commanded(self, stamp: float, wanted: Array, now: float) -> None:
        """A command with this stamp is taken over."""
        self._taken.append((stamp, now))
        self._wanted = wanted
        self._holding = 0.0

    def executed(self, twist: Array, dt: float) -> None:
        """The gate lets ``twist`` through for ``dt`` [s], which counts as far as it is the command."""
        speed = float(np.linalg.norm(self._wanted))
        self._holding += dt * float(np.linalg.norm(twist)) / speed if speed > 0.0 else 0.0
        self.held = max(self.held, self._holding)

    def delays(self) -> list[float]:
        """Delay [s] of each command from its sample."""
        found = []
        for stamp, taken in self._taken:
            wrench = bisect_left(self._wrenches, stamp)
            sample = bisect_left(self.sent, self._wrenches[wrench - 1]) if wrench > 0 else 0
            if sample > 0:
                found.append(taken - self.sent[sample - 1])
        return found
