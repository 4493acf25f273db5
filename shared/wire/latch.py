"""The latch of the robot's gate as a person works it: a stop or a release is said until the robot shows it."""

from __future__ import annotations

import threading
import time

from shared import topics
from shared.messages import ControlStatus, RobotStatus, Stop
from shared.wire.client import Client, forbidden, unheard
from shared.wire.subscription import Subscription

CONFIRM_WITHIN = 3.0  # [s]
REPEAT = 0.1  # [s] between two messages: one alone could be lost, and a stop must not be


class Latch:
    """Says stop and release, each in the thread of whoever calls; the newest word ends whatever is still being said.

    Args:
        client: says it.
        robot, controller: what shows that it is done.
        within: time [s] for which it is said without an effect.
    """

    def __init__(
        self,
        client: Client,
        robot: Subscription[RobotStatus],
        controller: Subscription[ControlStatus],
        within: float = CONFIRM_WITHIN,
    ) -> None:
        self._client, self._robot, self._controller, self._within = client, robot, controller, within
        self._lock = threading.Lock()
        self._newest: Stop | None = None

    def say(self, message: Stop) -> str:
        """Say a stop or a release until the robot shows it, for no longer than ``within``.

        Returns:
            Why it is not certain that it is done; empty if it is.
        """
        wanted = "stopped" if message.engaged else "released"
        begun, deadline, latched = self._client.clock.now_ns(), time.monotonic() + self._within, ""
        with self._lock:
            self._newest = message
        while time.monotonic() < deadline:
            with self._lock:
                if self._newest is not message:
                    return f"not confirmed: somebody wanted the contrary before the robot showed {wanted}"
                self._client.publish(topics.STOP, message)
            time.sleep(REPEAT)
            shown, controller = self._robot.latest, self._controller.latest
            reason = controller.message.reason if controller else ""
            latched = reason if not message.engaged and "latched" in reason else ""
            if shown is None or shown.arrival_ns < begun or latched:
                continue
            if (shown.message.mode == "stopped") == message.engaged:
                return ""
        # It was sent all the same: a stop is worth trying.
        if why := forbidden(topics.STOP, self._client.credentials):
            return why
        newest = self._robot.latest
        if newest is None or newest.arrival_ns < begun:
            silent = unheard(self._robot) or "no message of the robot since then. See: tandem status"
            return f"sent, but no robot has answered: {silent}"
        if latched:
            return f"the robot is released, but not the controller: {latched}"
        return f"sent, but the robot does not show {wanted} within {self._within:g} s (it is {newest.message.mode})"
