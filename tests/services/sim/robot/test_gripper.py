"""The fingers: how they move, and how a stop and its release leave them where they are with what they hold."""

from __future__ import annotations

import numpy as np
import pytest

from services.sim.robot.gripper import Gripper
from shared import topics
from shared.messages import GripperCommand, HeadCommand, Stop
from shared.robot.tiago import FINGER_EFFORT, FINGER_SPEED, FINGER_TRAVEL
from tests.services.sim.rig import Rig

OPENED = GripperCommand(0.09, FINGER_EFFORT)
PRESSED = 2500.0
"""Force [N] of a pad per metre by which it is pressed in, about as in ``services.sim.scene.grip``."""


@pytest.fixture
def rig() -> Rig:
    return Rig(scene="carry", ft_noise=[0.0] * 6, panel_mass=0.4)


def stop(rig: Rig, duration: float = 0.5) -> None:
    rig.stack.client.publish(topics.STOP, Stop(True, "hand on the button"))
    rig.run(duration)


def release(rig: Rig, duration: float = 1.0) -> None:
    rig.stack.client.publish(topics.STOP, Stop(False, ""))
    rig.run(duration)


def test_the_fingers_move_at_their_speed_and_as_far_as_they_can() -> None:
    gripper = Gripper()
    gripper.command(2 * FINGER_TRAVEL, FINGER_EFFORT)
    for _ in range(100):
        gripper.advance(0.002)
    assert gripper.opening == pytest.approx(2 * FINGER_SPEED * 0.2)
    for _ in range(1000):
        gripper.advance(0.002)
    assert gripper.opening == pytest.approx(2 * FINGER_TRAVEL)
    assert gripper.effort == 0.0 and not gripper.holding


def test_the_joint_state_shows_the_fingers(rig: Rig) -> None:
    rig.stack.client.publish(topics.COMMAND_GRIPPER, GripperCommand(0.06, 16.0))
    rig.run(1.5)
    joints = rig.last(topics.STATE_JOINTS)
    fingers = [joints.position[joints.name.index(f"gripper_right_{side}_finger_joint")] for side in ("left", "right")]
    assert fingers == pytest.approx([0.03, 0.03])
    assert rig.last(topics.STATE_GRIPPER).opening == pytest.approx(0.06)


def test_fingers_and_head_stay_where_they_are_until_they_are_told_anew_after_the_release(rig: Rig) -> None:
    rig.stack.client.publish(topics.COMMAND_GRIPPER, OPENED)
    rig.stack.client.publish(topics.COMMAND_HEAD, HeadCommand(1.2, 0.5))
    rig.run(0.3)
    stop(rig, 0.02)
    opening, head = rig.simulator.world.gripper.opening, rig.simulator.world.head.position.copy()
    assert 0.0 < opening < 0.05 and head[0] < 1.0
    for still in (stop, release):
        still(rig)
        assert rig.simulator.world.gripper.opening == opening
        assert (rig.simulator.world.head.position == head).all()
    rig.stack.client.publish(topics.COMMAND_GRIPPER, OPENED)
    rig.stack.client.publish(topics.COMMAND_HEAD, HeadCommand(1.2, 0.5))
    rig.run(2.0)
    assert rig.simulator.world.gripper.opening == pytest.approx(0.09)
    assert rig.simulator.world.head.position == pytest.approx((1.2, 0.5))


def lifted(rig: Rig) -> None:
    rig.grasp()
    rig.move((0, 0, 0.08), 2.0)
    rig.run(0.5)
    assert not rig.simulator.world.panel_scene.panel.supported


def held(rig: Rig, effort: float) -> bool:
    state, scene = rig.last(topics.STATE_GRIPPER), rig.simulator.world.panel_scene
    return state.holding and state.effort >= effort - 0.1 and not scene.panel.supported


def test_a_panel_that_is_held_stays_held_with_the_same_effort(rig: Rig) -> None:
    lifted(rig)
    stop(rig)
    assert held(rig, FINGER_EFFORT)
    rig.stack.client.publish(topics.COMMAND_GRIPPER, OPENED)
    rig.run(0.2)
    release(rig)
    assert held(rig, FINGER_EFFORT), "neither the stop nor what was asked meanwhile has opened the fingers"


@pytest.mark.parametrize("effort", [FINGER_EFFORT, 0.0])
def test_a_panel_that_is_being_let_go_of_when_the_stop_comes_is_held_again(rig: Rig, effort: float) -> None:
    lifted(rig)
    rig.stack.client.publish(topics.COMMAND_GRIPPER, GripperCommand(0.09, effort))
    rig.run(0.04)
    gripper = rig.simulator.world.gripper
    stop(rig, 0.02)
    pressed = min(gripper.pressed)
    assert 1.0 < pressed < FINGER_EFFORT - 1.0, "in the middle of opening"
    release(rig)
    assert held(rig, max(effort, pressed))


class Held:
    """A gripper around foam of a width [m] whose middle is off the fingers' by a shift [m]."""

    def __init__(self, width: float, shift: float = 0.0) -> None:
        self.gripper = Gripper()
        self.gripper.left = self.gripper.right = 0.045
        self._sides = np.array((0.5 * width + shift, 0.5 * width - shift))

    def run(self, duration: float) -> None:
        for _ in range(round(duration / 0.002)):
            self.gripper.advance(0.002)
            depth = self._sides - (self.gripper.left, self.gripper.right)
            left, right = (PRESSED * np.maximum(depth, 0.0)).tolist()
            self.gripper.pressed, self.gripper.holding = (left, right), min(left, right) >= 1.0


def test_fingers_that_touch_with_one_pad_only_when_the_stop_comes_go_on_closing() -> None:
    """For an instant a held panel may be off one of them: this must not be the instant that lets it go."""
    held = Held(0.05, shift=0.01)
    held.gripper.command(0.0, FINGER_EFFORT)
    while not any(held.gripper.pressed):
        held.run(0.002)
    assert not held.gripper.holding
    held.gripper.stay()
    held.run(2.0)
    assert held.gripper.holding and min(held.gripper.pressed) > FINGER_EFFORT - 1.0


def test_fingers_that_touch_nothing_stay_each_where_it_is() -> None:
    held = Held(0.05, shift=0.01)
    held.gripper.command(0.0, FINGER_EFFORT)
    held.run(1.0)
    held.gripper.command(0.09, FINGER_EFFORT)
    held.run(0.25)
    places = held.gripper.left, held.gripper.right
    assert not any(held.gripper.pressed) and places[0] != pytest.approx(places[1], abs=1e-3)
    held.gripper.stay()
    held.run(1.0)
    assert (held.gripper.left, held.gripper.right) == places
