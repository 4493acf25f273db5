"""The person: arms of a human's stiffness, bounded strength, and nothing but what can be seen and felt."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from services.sim.scene.hands import Hands, bounded
from services.sim.scene.panel import Panel, PanelSpec
from services.sim.scene.person import ENOUGH_FORCE, Person
from services.sim.scene.script import read
from shared import topics
from shared.parameters import Refused
from shared.sim_messages import HandState
from shared.spatial import GRAVITY, rotation_from_vector
from tests.services.sim.rig import Rig
from tests.services.sim.statics import reads, statics

STEP = 0.002
SPEC = PanelSpec((1.2, 0.6, 0.05), 1.5, 0.6, 4000.0, (0.57, -0.39, 0.78))
WEIGHT = 1.5 * GRAVITY
NOTHING = np.zeros(3)


def phases(*tables: str) -> str:
    """A script of the person, one phase after the other; entries are separated by semicolons."""
    return "".join(f"[[phase]]\ndo = {table}\n".replace("; ", "\n") for table in tables)


class Blocked(Panel):
    """A panel that does not move, whatever pushes it."""

    def step(self, force: np.ndarray, torque: np.ndarray, dt: float) -> None:
        pass


class Bench:
    """Person and panel, and nobody else."""

    def __init__(self, panel: Panel) -> None:
        self.panel = panel
        self.person = Person(Hands(60.0, 20.0))
        self.forces: list[float] = []
        self.torques: list[float] = []

    def act(self, *tables: str) -> None:
        self.person.act(read(phases(*tables)))

    def run(self, duration: float, gripped: bool = True) -> None:
        for _ in range(round(duration / STEP)):
            force, torque = self.person.step(self.panel, gripped, STEP)
            self.forces.append(float(np.linalg.norm(self.person.hands.force)))
            self.torques.append(float(np.linalg.norm(self.person.hands.torque)))
            self.panel.step(force, torque, STEP)


@pytest.mark.parametrize("share", [1.0, 0.5, 2.0])
def test_the_hands_are_as_stiff_as_a_human_arm_or_as_is_told(share: float) -> None:
    panel = Blocked(SPEC)
    hands = Hands(60.0, 20.0, 500.0 * share)
    hands.take_hold(panel)
    hands.step(panel, STEP)
    hands.position = hands.position + np.array((0.02, -0.01, 0.03))
    hands.rotation = rotation_from_vector((0.1, 0.2, -0.05)) @ hands.rotation
    hands.step(panel, STEP)
    hands.step(panel, STEP)
    assert hands.force == pytest.approx(share * np.array((10.0, -5.0, 15.0)))
    assert hands.torque == pytest.approx(share * np.array((4.0, 8.0, -2.0)))


@given(st.tuples(*[st.floats(-1e6, 1e6)] * 3))
def test_a_bounded_vector_keeps_its_direction(vector: tuple[float, ...]) -> None:
    result = bounded(np.array(vector), 60.0)
    assert np.linalg.norm(result) <= 60.0 * (1 + 1e-9)
    assert result @ np.array(vector) >= 0.0


def test_on_a_blocked_panel_the_person_stops_going_on_within_their_strength() -> None:
    bench = Bench(Blocked(SPEC))
    bench.person.guide(np.array((5.0, 5.0, 3.0)))
    bench.run(10.0)
    # Half the weight is added on top of what resists.
    assert max(bench.forces) <= ENOUGH_FORCE + 0.5 * WEIGHT + 0.5
    assert bench.person.hands.strain[0] == pytest.approx(ENOUGH_FORCE, abs=0.5)
    # Whatever the hands want, by surprise: the panel is torn away.
    bench.panel.body.position = bench.panel.body.position + np.array((0.5, 0.2, 0.0))
    bench.panel.body.rotation = rotation_from_vector((0.0, 1.0, 0.5))
    bench.panel.body.velocity = np.array((3.0, 0.0, 0.0))
    bench.run(1.0)
    assert max(bench.forces) <= 60.0 * (1 + 1e-9)
    assert max(bench.torques) <= 20.0 * (1 + 1e-9)
    assert max(bench.forces) > 59.0


@pytest.mark.parametrize(("size", "mass"), [((0.4, 0.1, 0.05), 0.3), ((1.0, 0.1, 0.02), 0.2), ((3.0, 0.1, 0.02), 0.2)])
def test_a_light_and_narrow_panel_does_not_spin_up_in_the_hands(size: tuple[float, float, float], mass: float) -> None:
    bench = Bench(Panel(replace(SPEC, size=size, mass=mass, near_edge=(0.57, -0.39, 0.9))))
    bench.act('"take_hold"', '"lift"; height = 0.3', '"turn"; about = "x"; angle = 45')
    fastest = 0.0
    for _ in range(400):
        bench.run(0.02)
        fastest = max(fastest, float(np.abs(bench.panel.body.spin).max()))
    assert 0.1 < fastest < 1.0


def test_a_weak_person_is_weak() -> None:
    bench = Bench(Blocked(SPEC))
    bench.person = Person(Hands(5.0, 1.0))
    bench.act('"move"; by = [2, 0, 0]', '"turn"; about = "x"; angle = 90')
    bench.run(50.0)
    assert max(bench.forces) <= 5.0 + 1e-9 and max(bench.torques) <= 1.0 + 1e-9


def test_the_person_turns_a_blocked_panel_no_harder_than_is_enough() -> None:
    bench = Bench(Blocked(SPEC))
    bench.act('"turn"; about = "x"; angle = 90')
    bench.run(30.0)
    assert 11.5 < max(bench.torques) < 13.0


def test_the_person_waits_until_the_fingers_are_closed_and_gives_up_waiting() -> None:
    script = '"wait"; until = "grasp"; patience = 3', '"take_hold"'
    bench = Bench(Panel(SPEC))
    bench.act(*script)
    bench.run(2.0, gripped=False)
    assert not bench.person.hands.holding
    bench.run(0.9, gripped=True)
    assert not bench.person.hands.holding
    bench.run(0.3, gripped=True)
    assert bench.person.hands.holding
    bench.person.hands.let_go()
    bench.act(*script)
    bench.run(3.5, gripped=False)
    assert not bench.person.hands.holding
    bench.run(1.0, gripped=False)
    assert bench.person.hands.holding


def test_the_person_lifts_their_end_and_carries_half_the_weight() -> None:
    bench = Bench(Panel(SPEC))
    bench.act('"lift"; height = 0.05; speed = 0.05')
    bench.run(4.0)
    # The near end lies on its trestle, a quarter of the length from its edge.
    arm = 0.3 + 0.6 - 0.03
    assert bench.panel.body.rotation[2, 0] > 0.02
    torque = bench.person.hands.torque[1]
    assert bench.person.hands.force[2] * arm - torque == pytest.approx(WEIGHT * 0.3, rel=0.05)


def test_the_person_brings_the_hands_to_a_target() -> None:
    bench = Bench(Panel(SPEC))
    bench.panel.body.position = np.array((1.0, 0.0, 1.0))
    bench.panel.supported = False
    target = np.array((1.9, 0.1, 1.0))
    bench.person.hands.lifting = 0.5 * WEIGHT
    bench.person.guide(target)
    bench.run(6.0)
    assert bench.person.hands.position == pytest.approx(target)
    assert bench.person.doing == "guided"


@pytest.mark.parametrize(("higher", "waits"), [(0.0, False), (0.1, False), (0.2, True)])
def test_the_person_lowers_their_end_no_further_while_the_other_one_is_much_higher(higher: float, waits: bool) -> None:
    panel = Blocked(SPEC)
    panel.body.rotation = rotation_from_vector((0.0, math.asin(higher / 1.2), 0.0))
    bench = Bench(panel)
    bench.act('"lower"; speed = 0.1')
    bench.run(0.1)
    start = bench.person.hands.position[2]
    bench.run(0.3)
    assert (bench.person.hands.position[2] < start - 0.02) != waits


def test_the_person_lets_go_gently() -> None:
    bench = Bench(Panel(SPEC))
    bench.act('"move"; by = [0.01, 0, -0.02]; pause = 0', '"let_go"; pause = 0')
    bench.run(5.0)
    assert not bench.person.hands.holding
    assert max(bench.forces) > 3.0 and bench.forces[-1] == 0.0
    # What was let go of in the end was next to nothing.
    assert next(force for force in reversed(bench.forces) if force > 0.0) < 0.05 * max(bench.forces)


def test_the_world_shows_the_hands_once_the_person_is_asked() -> None:
    rig = Rig(scene="carry", ft_noise=[0.0] * 6)
    assert rig.last(topics.SIM_WORLD).hand is None
    rig.ask(command="hand", target=[1.74, -0.39, 0.85])
    rig.run(3.0)
    hand = rig.last(topics.SIM_WORLD).hand
    assert hand.position == pytest.approx((1.74, -0.39, 0.85), abs=0.03)
    assert 1.0 < hand.force[2] < 20.0
    rig.ask(command="reset")
    rig.run(0.1)
    assert rig.last(topics.SIM_WORLD).hand is None


def test_the_world_tells_what_the_hands_want_and_what_they_have_if_they_let_go() -> None:
    rig = Rig(scene="carry")
    rig.ask(command="hand", script=phases('"wait"; until = "grasp"; patience = 5'))
    rig.run(0.1)
    world = rig.last(topics.SIM_WORLD)
    assert world.hand.wanted == pytest.approx(world.hand.position)
    assert world.hand.wanted_orientation == pytest.approx(world.panel.orientation)
    assert world.hand.position == pytest.approx((0.57 + 1.2 - 0.03, -0.39, 0.78), abs=1e-3)
    # The near end lies on its trestle: what is wanted and what is there differ.
    turn = '"lift"; height = 0.1; pause = 0', '"turn"; about = "z"; angle = 20; pause = 9'
    rig.ask(command="hand", script=phases(*turn))
    rig.run(6.0)
    hands, hand = rig.simulator.world.panel_scene.person.hands, rig.last(topics.SIM_WORLD).hand
    assert hand.wanted == pytest.approx((1.74, -0.39, 0.88), abs=2e-3)
    assert hand.wanted == pytest.approx(hands.position, abs=1e-6)
    assert np.linalg.norm(hand.wanted - hand.position) > 1e-3
    assert hand.wanted_orientation == pytest.approx((0.0, 0.0, math.sin(math.radians(10)), math.cos(math.radians(10))))


def test_a_hand_that_says_nothing_of_what_it_wants_is_read_all_the_same() -> None:
    hand = HandState.from_plain({"position": [1, 2, 3], "force": [0, 0, 0], "torque": [0, 0, 0]})
    assert hand.wanted == pytest.approx((0, 0, 0))
    assert hand.wanted_orientation == pytest.approx((0, 0, 0, 1))


def test_held_at_both_ends_the_wrist_carries_what_statics_say() -> None:
    rig = Rig(scene="carry", ft_noise=[0.0] * 6)
    rig.grasp()
    rig.ask(command="hand", script=phases('"lift"; height = 0.15; speed = 0.1'))
    for _ in range(30):
        rig.move((0, 0, 0.05), 0.1)
    rig.run(2.0)
    world, tool = rig.last(topics.SIM_WORLD), rig.last(topics.STATE_EE)
    assert not rig.simulator.world.panel_scene.panel.supported
    weight = np.array((0.0, 0.0, -WEIGHT))
    assert world.contact_force == pytest.approx(weight + world.hand.force, abs=0.05)
    assert world.contact_force[2] == pytest.approx(-0.5 * WEIGHT, abs=3.0)
    # About the tool: the panel's weight, and the hands' force and torque.
    about = (
        np.cross(world.panel.position - tool.position, weight)
        + np.cross(world.hand.position - tool.position, world.hand.force)
        + world.hand.torque
    )
    assert rig.simulator.world.contact_torque == pytest.approx(about, abs=0.05)
    wanted = statics(rig.simulator.world.arm.physics.position, weight + world.hand.force, about)
    assert reads(rig.reading, wanted), (rig.reading, wanted)


@pytest.mark.parametrize(("stiffness", "stands"), [(4000.0, False), (12000.0, True)])
def test_upright_it_stands_when_let_go_of_if_its_foam_is_stiff_enough(stiffness: float, stands: bool) -> None:
    # Its corners 25 mm from the middle have to outweigh a centre 0.3 m above them: 7.1 kN/m.
    spec = replace(SPEC, stiffness=stiffness)
    bench = Bench(Panel(spec))
    bench.panel.supported = False
    bench.panel.body.rotation = rotation_from_vector((math.radians(89.8), 0.0, 0.0))
    bench.panel.body.position = np.array((1.0, 0.0, 0.30))
    bench.act('"lower"', '"let_go"')
    bench.run(12.0)
    assert not bench.person.hands.holding
    assert (bench.panel.body.rotation[2, 1] > 0.99) == stands


def test_nonsense_is_refused() -> None:
    rig = Rig(scene="carry")
    for request, says in (
        ({}, "either script"),
        ({"script": "carry", "target": [0, 0, 0]}, "either script"),
        ({"script": 3}, "script is 3"),
        ({"target": [0, 0]}, "target has 2 elements, wanted 3"),
        ({"script": "dance"}, "neither 'carry' nor TOML"),
    ):
        with pytest.raises(Refused, match=says):
            rig.ask(command="hand", **request)
