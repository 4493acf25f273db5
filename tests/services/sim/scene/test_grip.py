"""The gripper holds what two fingers and friction hold, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from services.sim.robot.gripper import Gripper
from services.sim.scene.grip import PAD_WIDTH, mean_radius
from services.sim.scene.panel import Panel, PanelSpec
from services.sim.scene.panel_scene import PanelScene, PanelSceneSpec, Tool
from shared import topics
from shared.robot.tiago import CHAIN, FINGER_EFFORT, FINGER_TRAVEL
from shared.spatial import GRAVITY, rotation_from_vector, rotation_matrix
from tests.services.sim.rig import Rig
from tests.services.sim.statics import reads, statics

STEP = 0.002
EDGE = np.array((0.57, -0.39, 0.78))
FLAT = rotation_from_vector((-np.pi / 2, 0, 0))
LIFT = np.array((0.0, 0.0, 1.5 * GRAVITY))
NOTHING = np.zeros(3)
OVERLAP = 0.07


class PulledPanel(Panel):
    """A panel at whose centre somebody pulls with a force (3,) [N] and twists with a torque (3,) [Nm]."""

    pull = np.zeros(3)
    twist = np.zeros(3)

    def step(self, force: np.ndarray, torque: np.ndarray, dt: float) -> None:
        super().step(force + self.pull, torque + self.twist, dt)


class Bench:
    """A tool that stands still at the panel's edge, and somebody who may pull at the panel."""

    def __init__(
        self,
        friction: float = 0.9,
        shift: float = 0.0,
        opening: float = 2 * FINGER_TRAVEL,
        size: tuple[float, float, float] = (1.2, 0.6, 0.05),
        mass: float = 1.5,
    ) -> None:
        spec = PanelSpec(size, mass, 0.6, 4000.0, tuple(EDGE.tolist()))
        self.panel_scene = PanelScene(PanelSceneSpec(spec, friction), STEP)
        self.panel_scene.panel = self.panel = PulledPanel(spec)
        self.body = self.panel.body
        self.gripper = Gripper()
        self.gripper.left = self.gripper.right = opening / 2.0
        self.gripper.command(opening, FINGER_EFFORT)
        self.stand(EDGE + np.array((OVERLAP - 0.1, 0.0, shift)), FLAT)

    def stand(self, position: np.ndarray, rotation: np.ndarray) -> None:
        self.tool = Tool(position, rotation, np.zeros(3), np.zeros(3))

    def run(
        self, duration: float, pull: np.ndarray = NOTHING, twist: np.ndarray = NOTHING
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Let pull and twist change to these within half the time; returns the last wrench on the tool, tool axes."""
        begin = self.panel.pull, self.panel.twist
        wrench = None
        steps = round(duration / STEP)
        for step in range(steps):
            share = min(1.0, 2.0 * step / steps)
            self.panel.pull = begin[0] + share * (pull - begin[0])
            self.panel.twist = begin[1] + share * (twist - begin[1])
            self.gripper.advance(STEP)
            wrench = self.panel_scene.advance(self.tool, self.gripper)
        return wrench

    def gripped(self) -> Bench:
        """With the panel in the fingers, somebody else carrying all its weight."""
        self.gripper.command(0.0, FINGER_EFFORT)
        self.run(1.5)
        self.run(1.0, 0.9 * LIFT)
        self.panel.supported = False
        self.run(1.0, LIFT)
        assert self.gripper.holding
        return self


@pytest.mark.filterwarnings("error")
def test_pads_without_friction_hold_nothing_up() -> None:
    bench = Bench(friction=0.0)
    bench.gripper.command(0.0, FINGER_EFFORT)
    bench.run(1.5)
    assert bench.gripper.holding
    force, _ = bench.run(0.5, np.array((-3.0, 0.0, 0.0)))
    assert force == pytest.approx(np.zeros(3), abs=0.1)


@pytest.mark.parametrize(("size", "mass"), [((0.4, 0.1, 0.05), 0.3), ((1.0, 0.1, 0.02), 0.2), ((3.0, 0.1, 0.02), 0.2)])
def test_a_light_and_narrow_panel_does_not_spin_up_in_the_fingers(
    size: tuple[float, float, float], mass: float
) -> None:
    bench = Bench(3.5, size=size, mass=mass)
    bench.gripper.command(0.0, FINGER_EFFORT)
    bench.run(1.5)
    bench.run(0.5, twist=np.array((0.2, 0.0, 0.0)))
    bench.run(1.0)
    assert bench.gripper.holding and np.abs(bench.body.spin).max() < 0.1


def test_closed_on_the_panel_it_holds_with_the_effort_asked_for() -> None:
    bench = Bench()
    bench.gripper.command(0.0, 10.0)
    bench.run(2.0)
    assert bench.gripper.holding
    assert bench.gripper.effort == pytest.approx(10.0, abs=0.5)
    assert bench.gripper.opening == pytest.approx(0.05 - 2 * 10.0 / 2500.0, abs=1e-3)


@pytest.mark.parametrize("finger", ["left", "right"])
def test_one_finger_alone_holds_nothing(finger: str) -> None:
    bench = Bench()
    bench.gripper.command(0.0, 0.0)
    setattr(bench.gripper, finger, 0.024)
    wrench = bench.run(1.0)
    assert wrench is not None and abs(wrench[0][1]) > 0.3
    assert not bench.gripper.holding
    start = bench.body.position[0]
    # Only the supports' friction, 8.8 N, is in the way.
    bench.run(1.0, np.array((14.0, 0.0, 0.0)))
    assert bench.body.position[0] - start > 0.1
    assert not bench.gripper.holding


def test_a_panel_that_is_off_the_middle_is_gripped_where_it_is() -> None:
    bench = Bench(shift=0.008)
    bench.gripper.command(0.0, FINGER_EFFORT)
    bench.run(2.0)
    assert bench.gripper.holding
    assert bench.gripper.left - bench.gripper.right == pytest.approx(0.0, abs=0.017)
    assert bench.body.position[2] == pytest.approx(0.78, abs=0.01)


def test_nothing_is_held_where_there_is_no_panel() -> None:
    bench = Bench()
    bench.stand(EDGE - np.array((0.2, 0.0, 0.0)), FLAT)
    bench.gripper.command(0.0, FINGER_EFFORT)
    bench.run(2.0)
    assert not bench.gripper.holding and bench.gripper.opening == 0.0


def test_closed_fingers_bump_into_the_edge() -> None:
    bench = Bench(opening=0.0)
    wrench = bench.run(0.01)
    assert wrench is not None and wrench[0][0] < -10.0
    bench.run(1.0)
    assert not bench.gripper.holding
    # Pushed back as far as the fingers reached in.
    assert bench.body.position[0] > EDGE[0] + 0.6 + 0.8 * OVERLAP


def test_a_gripper_that_is_turned_wrong_bumps_into_the_panel() -> None:
    bench = Bench()
    bench.stand(bench.tool.position, np.eye(3))
    bench.gripper.command(0.0, FINGER_EFFORT)
    bench.run(1.0)
    assert not bench.gripper.holding


def test_it_holds_up_to_the_friction_and_slips_beyond() -> None:
    bench = Bench().gripped()
    start = bench.body.position[0]
    bound = 0.9 * sum(bench.gripper.pressed)
    assert bound == pytest.approx(0.9 * 2 * FINGER_EFFORT, rel=0.03)
    wrench = bench.run(2.0, LIFT + np.array((0.95 * bound, 0.0, 0.0)))
    assert wrench is not None and wrench[0][0] == pytest.approx(0.95 * bound, rel=0.01)
    assert bench.body.position[0] - start == pytest.approx(0.95 * bound / 5000.0, abs=1e-4)
    wrench = bench.run(0.15, LIFT + np.array((1.2 * bound, 0.0, 0.0)))
    assert wrench is not None and wrench[0][0] == pytest.approx(bound, rel=0.05)
    bench.run(0.5, LIFT + np.array((1.2 * bound, 0.0, 0.0)))
    assert bench.body.position[0] - start > 0.05


def test_it_pivots_about_the_fingers_beyond_what_friction_holds() -> None:
    bench = Bench().gripped()
    bound = 0.9 * sum(bench.gripper.pressed) * mean_radius(OVERLAP, PAD_WIDTH)
    bench.run(2.0, LIFT, np.array((0.0, 0.0, 0.9 * bound)))
    assert abs(bench.body.rotation[1, 0]) < 0.01
    bench.run(1.0, LIFT, np.array((0.0, 0.0, 1.5 * bound)))
    assert abs(bench.body.rotation[1, 0]) > 0.05


def test_a_panel_that_has_pivoted_far_is_held_as_well() -> None:
    bench = Bench().gripped()
    bound = 0.9 * sum(bench.gripper.pressed) * mean_radius(OVERLAP, PAD_WIDTH)
    while abs(bench.body.rotation[1, 0]) < np.sin(np.radians(35.0)):
        bench.run(0.1, LIFT, np.array((0.0, 0.0, 1.2 * bound)))
        assert bench.gripper.holding
    wrench = bench.run(2.0, LIFT)
    assert wrench is not None and bench.gripper.holding
    turned = abs(bench.body.rotation[1, 0])
    bench.run(1.0, LIFT)
    assert abs(bench.body.rotation[1, 0]) == pytest.approx(turned, abs=1e-3)


def test_opened_it_lets_the_panel_drop() -> None:
    bench = Bench(friction=3.5)
    bench.body.rotation = rotation_from_vector((np.pi / 2, 0, 0))
    bench.stand(bench.tool.position, np.eye(3))
    bench.panel.supported = False
    bench.gripper.left = bench.gripper.right = 0.0245
    bench.gripper.command(0.0, FINGER_EFFORT)
    bench.run(0.5, LIFT)
    assert bench.gripper.holding
    bench.gripper.command(2 * FINGER_TRAVEL, FINGER_EFFORT)
    bench.run(2.5)
    assert not bench.gripper.holding
    assert bench.body.position[2] < 0.35


@pytest.fixture
def rig() -> Rig:
    return Rig(scene="carry", ft_noise=[0.0] * 6, panel_mass=0.4)


def test_the_wrist_reads_the_panel_that_is_carried_at_one_end(rig: Rig) -> None:
    rig.grasp()
    state = rig.last(topics.STATE_GRIPPER)
    assert state.holding and state.effort == pytest.approx(16.0, abs=0.1)
    rig.move((0, 0, 0.08), 2.0)
    rig.run(1.0)
    world, joints = rig.last(topics.SIM_WORLD), rig.last(topics.STATE_JOINTS)
    assert rig.last(topics.STATE_GRIPPER).holding and not rig.simulator.world.panel_scene.panel.supported
    position = np.array([joints.position[joints.name.index(name)] for name in CHAIN])
    weight = np.array((0.0, 0.0, -0.4 * GRAVITY))
    lever = world.panel.position - rig.last(topics.STATE_EE).position
    wanted = statics(position, weight, np.cross(lever, weight))
    assert reads(rig.reading, wanted), (rig.reading, wanted)
    assert world.contact_force == pytest.approx(weight, abs=0.05)


def test_the_panel_moves_with_tool_and_base(rig: Rig) -> None:
    rig.grasp()
    rig.move((0, 0, 0.08), 2.0)
    rig.drive((0.2, 0.0, 0.2), 2.0)
    rig.run(2.0)
    world, tool, base = (rig.last(topics.SIM_WORLD), rig.last(topics.STATE_EE), rig.last(topics.STATE_BASE))
    assert rig.last(topics.STATE_GRIPPER).holding
    heading = rotation_from_vector((0, 0, base.yaw))
    # From the tool to the panel's centre: half its length less what is between the fingers, along the tool's x axis.
    reach = heading @ rotation_matrix(tool.orientation)[:, 0]
    place = np.array((*base.position, 0.0)) + heading @ tool.position + 0.6295 * reach
    assert world.panel.position == pytest.approx(place, abs=0.02)
