"""The multiplexer in front of the base, as ``twist_mux`` behaves: who has priority is forwarded, on arrival only.

It sends nothing by itself, no zero either: it is the base's own time-out that ends a motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Entry(NamedTuple):
    """A source of velocities, or a lock: what is below its priority is not heard while it is live.

    Attributes:
        timeout: [s] after its last message. A silent source is not live then, a silent lock is engaged; 0 = never.
    """

    priority: int
    timeout: float


SOURCES = {
    "/nav_vel": Entry(10, 0.5),
    "/servoing_cmd_vel": Entry(20, 0.5),
    "/key_vel": Entry(90, 0.5),
    "/rviz_joy_vel": Entry(95, 0.5),
    "/phone_vel": Entry(98, 0.5),
    "/marker_vel": Entry(99, 0.5),
    "/joy_vel": Entry(100, 0.5),
    "/tab_vel": Entry(100, 0.5),
}
"""Inputs of a TIAGo's (see NOTICE)."""
LOCKS = {
    "/pause_navigation": Entry(100, 0.0),
    "/stop_closing_loop": Entry(200, 0.0),
    "/joy_priority": Entry(100, 0.0),
}
"""Its locks; 0 = free until somebody engages them."""


class TwistMux:
    """Decides whose velocity reaches the base.

    Args:
        sources, locks: by topic.
    """

    def __init__(self, sources: Mapping[str, Entry] = SOURCES, locks: Mapping[str, Entry] = LOCKS) -> None:
        self.sources, self.locks = sources, locks
        self._heard: dict[str, float] = {}
        self._engaged: dict[str, tuple[bool, float]] = {}

    def lock(self, topic: str, engaged: bool, now: float) -> None:
        """Take over what a lock's topic says at a time [s]."""
        self._engaged[topic] = engaged, now

    def passes(self, topic: str, now: float) -> bool:
        """Whether the velocity that arrives on a source's topic at a time [s] is forwarded."""
        self._heard[topic] = now
        return topic == max(
            (name for name in self.sources if self._live(name, now)),
            key=lambda name: self.sources[name].priority,
            default=None,
        ) and not self.held_by(topic, now)

    def held_by(self, topic: str, now: float) -> str:
        """The lock that keeps a source's velocities from the base, by its topic; empty if none does."""
        priority = self.sources[topic].priority
        return next((name for name, lock in self.locks.items() if lock.priority > priority and self._on(name, now)), "")

    def _live(self, topic: str, now: float) -> bool:
        heard, timeout = self._heard.get(topic), self.sources[topic].timeout
        return heard is not None and (timeout == 0.0 or now - heard <= timeout)

    def _on(self, topic: str, now: float) -> bool:
        engaged, since = self._engaged.get(topic, (False, None))
        timeout = self.locks[topic].timeout
        return engaged or (timeout > 0.0 and (since is None or now - since > timeout))
