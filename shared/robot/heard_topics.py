"""What was heard of a robot on the topics that its profile names: of a ``FarSide``, what no middleware changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from shared.robot.far_side import Heard, Joints, Odometry, Wrench
from shared.robot.profile import Profile


class Newest(Protocol):
    """The newest message of a topic, and what was refused there."""

    @property
    def heard(self) -> Heard[Any] | None: ...

    @property
    def refusals(self) -> str: ...


class HeardTopics:
    """Looks up what is asked for by its meaning.

    Args:
        profile: of the robot.
        newest: by topic, for all that the profile has heard.
    """

    def __init__(self, profile: Profile, newest: Mapping[str, Newest]) -> None:
        self._profile, self._by_topic = profile, newest

    def joints(self) -> Heard[Joints] | None:
        return self._by_topic[self._profile.joints.topic].heard

    def wrench(self) -> Heard[Wrench] | None:
        return self._by_topic[self._profile.wrench.topic].heard

    def odometry(self) -> Heard[Odometry] | None:
        base = self._profile.base
        return self._by_topic[base.odometry].heard if base else None

    def pressed(self) -> Heard[bool] | None:
        enable = self._profile.enable
        return self._by_topic[enable.topic].heard if enable else None

    def _refused(self) -> dict[str, str]:
        """By topic, what was refused there; empty texts where nothing was."""
        return {topic: newest.refusals for topic, newest in self._by_topic.items()}
