"""When commands go out: often enough for everybody who counts on them, also if a step is late."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from services.task.geometry import Pose
from services.task.outbox import Outbox
from services.task.parameters import TaskParameters
from services.task.states import Decision, State
from shared.messages import GripperCommand
from shared.topics import COMMAND_GRIPPER, CONTROL_TARGET
from shared.wire.subscription import HANDOVER_LIMIT

DECISION = Decision("", Pose(np.zeros(3), np.eye(3)), gripper=GripperCommand(0.0, 16.0))


def longest_gap(steps: list[float], key: str) -> float:
    """Longest time [s] without a message of a key."""
    outbox, now, last, longest = Outbox(TaskParameters()), 0.0, 0.0, 0.0
    for dt in steps:
        now += dt
        if any(output.topic.key == key for output in outbox.commands(State.CARRYING, DECISION, dt)):
            longest, last = max(longest, now - last), now
    return max(longest, now - last)


@given(st.lists(st.floats(0.01, 0.1), min_size=50, max_size=200))
def test_nobody_may_take_the_gripper_over_because_the_task_is_late(steps: list[float]) -> None:
    assert longest_gap(steps, COMMAND_GRIPPER.key) < 0.6 * HANDOVER_LIMIT


def test_the_target_comes_at_more_than_5_hz_also_if_single_steps_are_late() -> None:
    assert longest_gap([0.02, 0.02, 0.03] * 100, CONTROL_TARGET.key) < 0.2
