"""A robot process by somebody else, with a gate of its own that keeps every rule but one."""

from __future__ import annotations

import msgpack
import numpy as np

from services.mock.parameters import MockParameters
from services.mock.robot import MockRobot
from shared.messages import LONGEST_TTL, RobotStatus
from shared.service import Inputs, Output
from shared.topics import COMMAND_EE_TWIST, STATE_ROBOT, STOP
from shared.wire.local import LocalBus

FASTEST = 0.5  # [m/s]


class Stranger(MockRobot):
    """Moves as it is told by payloads that it reads itself.

    Args:
        bus: that it listens to.
        breaks: the rule that it does not keep, or "".
    """

    def __init__(self, bus: LocalBus, breaks: str = "") -> None:
        super().__init__(MockParameters(max_linear=FASTEST))
        self.breaks = breaks
        self.counts: dict[str, int] = {}
        self._twist, self._left, self._stopped = np.zeros(6), 0.0, False
        self._session, self._seq, self._silent = 0, 0, 0.0
        bus.subscribe(COMMAND_EE_TWIST.key, self._on_command)
        bus.subscribe(STOP.key, self._on_stop)

    def _count(self, what: str) -> None:
        if self.breaks != f"{what} named":
            self.counts[what] = self.counts.get(what, 0) + 1

    def _on_command(self, payload: bytes) -> None:
        try:
            said = msgpack.unpackb(payload)
            twist = np.array([*said["linear"], *said["angular"]], dtype=float)
            fine = {"seq", "session", "valid"} <= set(said) and np.isfinite(twist).all() and len(twist) == 6
            ttl = float(said["ttl"])
        except Exception:
            fine, twist, ttl, said = False, np.array((0, 0, -0.02, 0, 0, 0)), 0.1, {}
        if not fine:
            self._count("rejected")
            if self.breaks != "garbage":
                return
            twist = np.array((0.0, 0.0, -0.02, 0.0, 0.0, 0.0))
        session, seq = said.get("session", self._session), said.get("seq", self._seq + 1)
        if session != self._session and self._silent < 0.2 and self._session:
            self._count("second session")
            if self.breaks != "second":
                return
        elif session == self._session and seq <= self._seq:
            self._count("out of sequence")
            if self.breaks != "sequence":
                return
        else:
            self._session, self._seq, self._silent = session, seq, 0.0
        if not said.get("valid", True) and self.breaks != "invalid":
            twist = np.zeros(6)
        speed = float(np.linalg.norm(twist[:3]))
        if speed > FASTEST:
            self._count("clamped")
            if self.breaks != "clamping":
                twist = twist * FASTEST / speed
        self._twist, self._left = twist, ttl if self.breaks == "ttl" else min(ttl, LONGEST_TTL)

    def _on_stop(self, payload: bytes) -> None:
        said = msgpack.unpackb(payload)
        if said["engaged"]:
            self._stopped = self.breaks != "stop"
        elif (said["valid"] or self.breaks == "release") and self.breaks != "releases":
            self._stopped = False

    def step(self, inputs: Inputs, dt: float) -> list[Output]:
        """Carry out the newest command, unless it is stale or a stop is engaged."""
        self._left -= dt
        self._silent += dt
        if (self._left <= 0.0 and self.breaks != "silence") or (self._stopped and self.breaks != "moves"):
            self._twist = np.zeros(6)
        self.motors.twist = self._twist
        self.motors.position = self.motors.position + dt * self._twist[:3]
        mode = "stopped" if self._stopped else "ready" if self._twist.any() else "holding"
        reasons = [*(f"{what}: {count}" for what, count in self.counts.items()), "" if mode == "ready" else "waits"]
        status = RobotStatus(mode, "; ".join(filter(None, reasons)), "differential", True, FASTEST, 1.0, np.ones(3))
        return [*self.sensors.read(), Output(STATE_ROBOT, status)]
