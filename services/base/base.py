"""The base service: one base twist per external wrench."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from services.base.admittance import REST, Admittance, SpeedLimits
from services.base.parameters import BaseParameters
from services.base.planar_wrench import Planar, about_base, beyond_dead_band, error_about_base
from shared import topics
from shared.faults import SHUTDOWN, Fault
from shared.loop.halt import Halt
from shared.messages import BaseStatus, BaseTwistCommand, RobotStatus
from shared.service import Inputs, Output, Service, Wiring

TTL = 0.1  # [s] for which the robot may execute a command: three of the longest periods of a wrench


class Base(Service[BaseParameters]):
    """Lets the external wrench push the base about while ``base/enable`` says so; otherwise brings it to rest.

    The velocity is the one commanded: what the wheels make of it is not fed back. After a brake that is long enough to
    wait for healthy inputs again it begins from rest, since no robot executes commands that are marked invalid.
    """

    wiring = Wiring(
        name="base",
        driver=topics.WRENCH_EXTERNAL,
        required=(topics.WRENCH_EXTERNAL, topics.STATE_EE, topics.STATE_ROBOT),
        optional=(topics.BASE_ENABLE, topics.STOP),
        parameters=topics.BASE_PARAMETERS,
    )

    def __init__(self, parameters: BaseParameters) -> None:
        self.apply(parameters)
        self._halt = Halt()
        self._sessions: tuple[int, int] | None = None
        self._outdated = False
        self._wrench: Planar = REST
        self._velocity: Planar = REST
        self._unused = 0.0
        self._note = ""
        self._robot: RobotStatus | None = None

    def step(self, inputs: Inputs, dt: float) -> Iterator[Output]:
        """The velocity that the newest wrench leads to, then the status."""
        self._unused = dt
        self._halt.listen(inputs)
        drive = self._feel(inputs)
        robot = inputs[topics.STATE_ROBOT].message
        enabled = self._enabled(inputs)
        stopped = f"the robot is stopped: {robot.reason}" if robot.mode == "stopped" else ""
        stuck = "" if (robot.max_base > 0.0).any() else f"{topics.STATE_ROBOT.key}.max_base is zero: it cannot move"
        self._note = self._halt.reason or stopped or (stuck if enabled else "")
        self._robot = robot
        following = enabled and not self._note
        if following:
            velocity = self._body.follow(self._velocity, drive, self._limits(robot), dt)
        else:
            velocity = self._body.brake(self._velocity, dt)
        # A robot that begins to allow less is obeyed at once, whatever deceleration that takes.
        self._velocity, self._unused = _allowed_by(robot).clip(velocity), 0.0
        return self._outputs("following" if following else self._resting())

    def brake(self, fault: Fault, dt: float) -> Iterator[Output]:
        """A velocity closer to rest."""
        self._halt.fault(fault, dt)
        self._note = self._halt.latched
        # The last word of a process is zero: nobody would send the rest of the way down.
        if fault.waiting or fault is SHUTDOWN:
            self._velocity = REST
        else:
            # A step that failed has let its time pass without slowing down.
            self._velocity = self._body.brake(self._velocity, dt + self._unused)
        self._unused = 0.0
        return self._outputs(self._resting() if fault.waiting else "braking")

    def apply(self, parameters: BaseParameters) -> None:
        """Take over parameters; the velocity goes on from where it is."""
        self.parameters = parameters
        self.max_delay = parameters.max_delay
        self._body = Admittance(
            parameters.mass,
            parameters.inertia,
            parameters.damping_linear,
            parameters.damping_angular,
            parameters.max_linear_acceleration,
            parameters.max_angular_acceleration,
        )

    def notes(self) -> str:
        """Why the base rests although the task may have enabled it, and which parameters have no effect."""
        ignored = self.parameters.ignored(self._robot) if self._robot else ""
        return "; ".join(filter(None, (self._note, ignored)))

    def _feel(self, inputs: Inputs) -> Planar:
        """The wrench about the base's origin, beyond the dead band."""
        wrench, position = (inputs[topics.WRENCH_EXTERNAL].message, inputs[topics.STATE_EE].message.position.tolist())
        felt = about_base(wrench.force.tolist(), wrench.torque.tolist(), position)
        if not math.isfinite(felt[2]):
            raise ArithmeticError("the wrench carried over to the base's origin is not finite")
        self._wrench = felt
        ex, ey, ez = error_about_base(wrench.error_bound.tolist(), position)
        force, torque = self.parameters.dead_band_force, self.parameters.dead_band_torque
        return beyond_dead_band(felt, (max(force, ex), max(force, ey), max(torque, ez)))

    def _enabled(self, inputs: Inputs) -> bool:
        """Whether the task enables the base: recently, and for the robot as it is since its last restart."""
        enable = inputs.get(topics.BASE_ENABLE)
        sessions = inputs[topics.STATE_EE].header.session, inputs[topics.STATE_ROBOT].header.session
        restarted = self._sessions not in (None, sessions)
        self._sessions = sessions
        if enable is None:
            return False
        if restarted:
            # The loop has watched the restarted robot for the whole start-up: what is older was meant for the other.
            self._outdated = enable.age > self.wiring.startup
        elif enable.new:
            self._outdated = False
        fresh = not self._outdated and enable.age <= topics.BASE_ENABLE.max_age
        return fresh and enable.header.valid and enable.message.enabled

    def _limits(self, robot: RobotStatus) -> SpeedLimits:
        """Limits of the parameters and of the robot together."""
        own, allowed = self.parameters, _allowed_by(robot)
        differential = robot.base_type == "differential"
        forwards = min(own.max_linear, allowed.forwards)
        return SpeedLimits(
            forwards=forwards,
            backwards=min(forwards, own.max_reverse) if differential else forwards,
            sideways=min(own.max_linear, allowed.sideways),
            linear=own.max_linear,
            angular=min(own.max_angular, allowed.angular),
        )

    def _resting(self) -> str:
        """The state without following: braking if a person is needed or the base still moves, else off."""
        return "braking" if self._halt.latched or any(self._velocity) else "off"

    def _outputs(self, state: str) -> Iterator[Output]:
        """The command, then the status, made after the command has left."""
        velocity = np.array(self._velocity)
        yield Output(topics.COMMAND_BASE_TWIST, BaseTwistCommand(velocity, ttl=TTL))
        yield Output(topics.BASE_STATUS, BaseStatus(state, np.array(self._wrench), velocity))


def _allowed_by(robot: RobotStatus) -> SpeedLimits:
    """Limits of ``state/robot.max_base``; the wheels of a differential base allow nothing sideways."""
    vx, vy, wz = (max(0.0, speed) for speed in robot.max_base.tolist())
    return SpeedLimits(vx, vx, 0.0 if robot.base_type == "differential" else vy, math.inf, wz)
