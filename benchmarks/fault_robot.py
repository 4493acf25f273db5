"""A robot whose gate tells when it stops: it publishes its sensors at 100 Hz and runs the real gate at 500 Hz."""

from __future__ import annotations

import threading

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.clock import SteadyClock
from shared.processes import LINKED
from shared.service import Inputs, Output
from shared.topics import ROBOT
from shared.wire.links import NONE, links_of
from tests.support.spoilt_bus import SpoiltBus, live

RATE, STEPS = 100.0, 5
"""Samples per second, and looks of the gate per sample."""


class FaultRobot(MockRobot):
    """Stands still in front of a target that it is asked to move to, and notes what its gate lets through.

    Attributes:
        bus: on which its messages can be spoilt.
        moving: whether the gate lets a motion through at present.
        stopped_ns: when it last ceased to.
        moving_ns: since when it moves without a break.
        longest_gap: longest time [s] between two looks of its gate, since set to zero; nominally 2 ms.
    """

    def __init__(self, endpoint: str, links: str = NONE) -> None:
        super().__init__(MockParameters(rate=RATE, pose_rate=RATE, steps=STEPS, still=True, max_linear=0.3))
        self.bus = SpoiltBus(endpoint, links=links_of(ROBOT, LINKED, links, "tiago", endpoint))
        self.stopped_ns = self.moving_ns = 0
        self.moving = False
        self.longest_gap = 0.0
        self._clock = SteadyClock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=live, args=(self, self.bus, self._ended.is_set))
        self._thread.start()

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """As the mock does; notes when motion begins and ends."""
        began = self._clock.now_ns()
        self.longest_gap = max(self.longest_gap, dt)
        outputs = super().step(inputs, dt)
        moving = bool(self.motors.twist.any())
        if moving and not self.moving:
            self.moving_ns = began
        if self.moving and not moving:
            self.stopped_ns = self._clock.now_ns()
        self.moving = moving
        return outputs

    def moves_for(self, duration: float) -> bool:
        """Whether it has been moving without a break for so long [s]."""
        return self.moving and self._clock.now_ns() - self.moving_ns > duration * 1e9

    def stands_for(self, duration: float) -> bool:
        """Whether it has been standing without a break for so long [s]."""
        return not self.moving and self._clock.now_ns() - self.stopped_ns > duration * 1e9

    def close(self) -> None:
        """End the robot."""
        self._ended.set()
        self._thread.join()
        self.bus.close()
