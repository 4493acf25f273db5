"""A bridge: a robot behind its middleware, as the contract knows robots.

    from shared.loop.process import run
    from shared.robot.bridge.bridge import Bridge

    def main(arguments=None):
        return run(lambda parameters: Bridge(parameters, MySide), MyParameters, "bridge_mine", arguments)

`MySide(profile, parameters)` is a ``FarSide``, which begins to connect when it is made, and never waits. All else is
here: the gate, inverse kinematics, trajectories that end at rest, the stop latch and the watch over what is heard.

A bridge starts with its stop engaged, and engages it again whenever the robot cannot be trusted to do as it is told:
nothing moves, or goes on, that a person has not released.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from shared.clock import Clock, SteadyClock, nanoseconds, seconds
from shared.faults import Fault
from shared.messages import BaseState
from shared.robot.base_gate import BaseLimits
from shared.robot.bridge.arm import Arm
from shared.robot.bridge.base import BaseDrive
from shared.robot.bridge.eye import Eye
from shared.robot.bridge.held import Fingers, Head
from shared.robot.bridge.motion import HORIZON, REST_WITHIN
from shared.robot.bridge.parameters import BridgeParameters
from shared.robot.bridge.watch import Watch
from shared.robot.far_side import FarSide
from shared.robot.gate import GateLimits
from shared.robot.profile import Profile
from shared.robot.side import RobotSide
from shared.service import Inputs, Output, Service, Wiring
from shared.spatial import Array
from shared.topics import OPERATOR_ENABLE, SENSOR_CAMERA, SENSOR_FT, STATE_BASE, STATE_EE, STATE_GRIPPER, STATE_JOINTS

P = TypeVar("P", bound=BridgeParameters)

STALLED = 0.25
"""[s] between two steps after which the robot is at rest, and stays so."""
RELEASES_KEPT = 0.5
"""[s] after such a pause in which a release counts for nothing: it may have waited on its way for long."""
JUST_STARTED = "the bridge has just started"
READ_ONLY = "read-only: this bridge watches, and commands nothing"
_MISSED = 2.5  # periods of joint states after which some are missing
_TELL_EVERY = 0.2  # [s] between two looks for what differs from the profile
_FIXED = BaseLimits(0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
_ZERO: Array = np.zeros(3)
_STANDING: Array = np.zeros(6)


class Bridge(Service[P]):
    """The service of a bridge.

    Attributes:
        far: the robot's own side.
        side: the gate, with the commands in front of it and ``state/robot`` behind it.

    Args:
        parameters: its own.
        make: makes the far side; may raise ``Refused`` for what cannot work, in one line.
        clock: that the far side's arrivals are told by.
        wall: this machine's wall clock [ns]; the robot's stamps are compared with it, nothing else is.

    Raises:
        Refused: the profile, or what ``make`` refuses.
    """

    def __init__(
        self,
        parameters: P,
        make: Callable[[Profile, P], FarSide],
        clock: Clock | None = None,
        wall: Callable[[], int] = time.time_ns,
    ) -> None:
        super().__init__(parameters)
        profile, scale = Profile.load(parameters.profile), parameters.scale
        self._profile = profile
        self._clock = clock or SteadyClock()
        self._watch = Watch(profile, wall)
        self._arm = Arm(profile, scale, 1.0 / parameters.command_rate)
        self._drive = BaseDrive() if profile.base else None
        self._head = Head(profile, scale) if profile.head else None
        self._fingers = Fingers(profile, scale) if profile.gripper else None
        self._eye = Eye(profile.camera) if profile.camera else None
        self.side = RobotSide(
            GateLimits(
                scale * parameters.max_linear,
                scale * parameters.max_angular,
                scale * parameters.max_linear_acceleration,
                scale * parameters.max_angular_acceleration,
            ),
            # The contract has no word for a base that there is none of; its limits say that it cannot move.
            "omni" if profile.base_type == "omni" else "differential",
            simulated=False,
            base=profile.base.limits(scale) if profile.base else _FIXED,
            gripper=profile.gripper_ranges(),
            head=profile.head_ranges(),
            require_enable=parameters.require_enable,
        )
        self.far = make(profile, parameters)
        self.wiring = Wiring(
            name="robot",
            driver=1.0 / parameters.rate,
            optional=RobotSide.INPUTS,
            on_demand=(SENSOR_CAMERA,) if profile.camera else (),
            # A late step is no reason to stand still: the gate watches over the commands' age.
            overrun_share=1.0,
        )
        self._blind_after = max(HORIZON, _MISSED / profile.joints.rate)
        self._last = self._clock.now_ns()
        self._woke = self._last - nanoseconds(RELEASES_KEPT)
        self._known = False
        self._cause = ""
        self._lines: tuple[str, ...] = ()
        self._until_lines = self._until_gripper = self._until_base = 0.0
        self._stop(JUST_STARTED)

    def step(self, inputs: Inputs, dt: float) -> Iterator[Output]:
        """Carry out for ``dt`` [s] what the gate lets through, and tell what the robot has said."""
        now, passed = self._passed()
        self._watch.look(self.far, now)
        stopped = self.side.mode == "stopped"
        awake = seconds(now - self._woke) >= RELEASES_KEPT
        self.side.take(inputs, pressed=self._pressed(now), releasable=awake)
        freeze = self._guard(now, passed) or self.side.freeze
        if stopped and self.side.mode != "stopped":
            self._released()
        self._command(now, dt, passed, freeze)
        yield from self._told(now, dt)
        if self._eye:
            yield from self._eye.look(self.far, self._watch.state, inputs.wanted(SENSOR_CAMERA), now)
        yield from self.side.report(dt, *self._reasons(dt))

    def brake(self, fault: Fault, dt: float) -> list[Output]:
        """Everything comes to rest while the loop does not work."""
        now, passed = self._passed()
        self._watch.look(self.far, now)
        outputs = self.side.hold(fault.text)
        freeze = self._guard(now, passed)
        self._command(now, dt, passed, freeze)
        return outputs

    def notes(self) -> str:
        """What differs from the profile."""
        return "; ".join(self._lines)

    def close(self) -> None:
        """Leave the robot, once it is at rest: its controllers are handed back then."""
        if self._drive and self._drive.moving:
            self.far.drive(_ZERO)
        if self._arm.moving:
            time.sleep(REST_WITHIN)
        self.far.close()

    def _passed(self) -> tuple[int, float]:
        """Now [ns], and the time [s] since the last call, however long that is."""
        now = self._clock.now_ns()
        passed, self._last = seconds(now - self._last), now
        return now, passed

    def _pressed(self, now: int) -> bool:
        """Whether the enabling device of the robot's own is pressed; silence means that it is let go."""
        device = self.far.pressed()
        return device is not None and device.message and seconds(now - device.arrival) <= OPERATOR_ENABLE.max_age

    def _guard(self, now: int, passed: float) -> bool:
        """Engage the stop if something asks for it; whether that has just happened."""
        self._cause = self._asks_for_a_stop(now, passed)
        if passed > STALLED:
            self._woke = now
            self.side.base_gate.rest()
        if not self._cause or self.side.mode == "stopped":
            return False
        self._stop(self._cause)
        return True

    def _asks_for_a_stop(self, now: int, passed: float) -> str:
        if self.parameters.read_only:
            return READ_ONLY
        if who := self.far.emergency():
            return f"the robot's emergency stop is pressed, says {who}"
        if passed > STALLED:
            return f"the bridge stood still for {passed:.1f} s"
        return self._watch.silence(now) or self.far.ready()

    def _stop(self, reason: str) -> None:
        self.side.gate.stop(True, reason)
        self.side.base_gate.stop(True)

    def _released(self) -> None:
        """Somebody may have led the arm elsewhere meanwhile, or hung something on it."""
        if not self._arm.moving:
            self._arm.start(self._watch.state.position)
        self._watch.forget_weights()

    def _command(self, now: int, dt: float, passed: float, freeze: bool) -> None:
        """Tell the robot's controllers what the gate lets through for ``dt`` [s]."""
        twist, velocity = self.side.advance(dt), self.side.advance_base(dt)
        state = self._watch.state
        if self.parameters.read_only or not state.positions:
            return
        if not self._known:
            self._known = True
            self._arm.start(state.position)
        if state.age(now) > self._blind_after:
            # It brakes as it does by itself where nothing reaches it any more: what is kept on the way there, and
            # arrives when it has long been at rest, leads to where it is and not on.
            twist = _STANDING
        told = list(self._arm.advance(twist, state.extrapolated(now), passed))
        sent = self._drive.advance(velocity, self._watch.base_velocity, passed) if self._drive else None
        if seconds(self._clock.now_ns() - now) > STALLED:
            return  # it hung in the midst of this step: the robot has come to rest meanwhile
        for controller, points in told:
            self.far.move(controller, points)
        if sent is not None:
            self.far.drive(sent)
        self._hold(passed, freeze)

    def _hold(self, passed: float, freeze: bool) -> None:
        """Head and fingers."""
        measured = self._watch.state.positions
        if self._head:
            self._head.advance(passed)
            points = self._head.freeze(measured) if freeze else ()
            if self.side.head is not None:
                points = self._head.command(self.side.head, measured)
            if points:
                self.far.move(self._head.controller, points)
        if self._fingers:
            points = self._fingers.advance(measured, passed)
            if freeze:
                points = self._fingers.freeze(measured)
            elif self.side.gripper is not None:
                points = self._fingers.command(self.side.gripper, measured)
            if points:
                self.far.move(self._fingers.controller, points)

    def _told(self, now: int, dt: float) -> Iterator[Output]:
        """What the robot has said since the last step, in the words of the contract; the pose before the sample."""
        watch, state = self._watch, self._watch.state
        if watch.joints is not None:
            late = seconds(now - watch.joints.arrival)
            yield Output(STATE_EE, state.tool(), late=late)
            yield Output(STATE_JOINTS, state.joint_state(watch.joints), late=late)
        if watch.wrench is not None and state.positions:
            valid = watch.wrench_in_frame and state.age(watch.wrench.arrival) <= STATE_JOINTS.max_age
            yield Output(SENSOR_FT, state.sample(watch.wrench), valid, seconds(now - watch.wrench.arrival))
            if self.side.mode == "stopped":
                watch.weigh()
        self._until_gripper -= dt
        if self._fingers and state.positions and self._until_gripper <= 0.0:
            self._until_gripper += 1.0 / STATE_GRIPPER.rate
            fresh = state.age(now) <= STATE_GRIPPER.max_age
            yield Output(STATE_GRIPPER, self._fingers.state(state.positions, state.efforts), fresh)
        yield from self._told_base(now, dt)

    def _told_base(self, now: int, dt: float) -> Iterator[Output]:
        odometry = self._watch.odometry
        if odometry is not None:
            told = odometry.message
            state = BaseState(told.position, told.yaw, told.velocity)
            yield Output(STATE_BASE, state, late=seconds(now - odometry.arrival))
        self._until_base -= dt
        if self._drive is None and self._until_base <= 0.0:
            self._until_base += 1.0 / STATE_BASE.rate
            yield Output(STATE_BASE, BaseState(_ZERO[:2], 0.0, _ZERO))

    def _reasons(self, dt: float) -> tuple[str, ...]:
        """Why the robot does not move as commanded, and what differs from the profile."""
        self._until_lines -= dt
        if self._until_lines <= 0.0:
            self._until_lines = _TELL_EVERY
            self._lines = tuple(self._all_lines())
        # A cause that has engaged the stop is told with it.
        cause = "" if self._cause in self.side.gate.reason else self._cause
        return (cause, self._arm.limited_by, *self._lines)

    def _all_lines(self) -> Iterator[str]:
        yield from self._watch.lines()
        if self._eye:
            yield from self._eye.lines()
        if self._drive and self._drive.blocked and self._profile.base:
            yield (
                f"the base does not move as {self._profile.base.topic} tells it to: a lock of twist_mux, a source of "
                "higher priority, or brakes?"
            )
        yield from (f"{topic}: {text}" for topic, text in self.far.refusals().items())
