"""The panel against statics: what it weighs where it lies, how far it sinks, when it slides, how it falls."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from services.sim.scene.panel import Panel, PanelSpec
from services.sim.scene.rigid_body import RigidBody
from shared.spatial import GRAVITY, rotation_from_vector

STEP = 0.002
SPEC = PanelSpec((1.2, 0.6, 0.05), 1.5, 0.6, 4000.0, (0.57, -0.39, 0.76))
WEIGHT = SPEC.mass * GRAVITY
NOTHING = np.zeros(3)
SIZE = np.array(SPEC.size)


def settle(panel: Panel, force: np.ndarray = NOTHING, offset: np.ndarray = NOTHING, time: float = 2.0) -> None:
    """Let a force (3,) that grows for half the time act at an offset (3,) from the centre."""
    steps = round(time / STEP)
    for step in range(steps):
        present = force * min(1.0, 2.0 * step / steps)
        panel.step(present, np.cross(offset, present), STEP)


def on_the_ground(rotation: np.ndarray) -> Panel:
    """A panel at rest on the ground in an attitude."""
    panel = Panel(SPEC)
    panel.supported = False
    panel.body.rotation = rotation
    panel.body.position = np.array((1.0, 0.0, np.abs(rotation[2]) @ SIZE / 2.0))
    settle(panel)
    return panel


def test_it_lies_still_on_its_supports() -> None:
    panel = Panel(SPEC)
    settle(panel)
    assert panel.body.position == pytest.approx((0.57 + 0.6, -0.39, 0.76), abs=1e-6)
    assert np.linalg.norm(panel.body.velocity) < 1e-6


def test_it_lies_as_still_on_supports_that_stand_askew() -> None:
    yaw = 0.3
    panel = Panel(replace(SPEC, yaw=yaw))
    settle(panel)
    centre = np.array(SPEC.near_edge) + 0.6 * np.array((math.cos(yaw), math.sin(yaw), 0.0))
    assert panel.body.position == pytest.approx(centre, abs=1e-6)
    assert panel.body.rotation == pytest.approx(rotation_from_vector((0.0, 0.0, yaw)), abs=1e-6)
    # Supports that did not stand below it would let it fall; their middles are on its own middle line.
    across = (panel.trestles - centre) @ panel.body.rotation[:, 1]
    assert across == pytest.approx((0.0, 0.0), abs=1e-9) and panel.heading == yaw


def test_lifting_its_weight_off_the_supports_takes_its_weight() -> None:
    panel = Panel(SPEC)
    settle(panel, np.array((0.0, 0.0, 0.99 * WEIGHT)))
    assert panel.body.position[2] < 0.76 + WEIGHT / SPEC.stiffness
    settle(panel, np.array((0.0, 0.0, 1.02 * WEIGHT)))
    assert panel.body.position[2] > 0.78


def test_a_weight_on_its_end_tips_it_when_statics_say_so() -> None:
    # About the nearer trestle: the weight's lever is 0.3 m, the push's 0.3 m.
    end = np.array((-SIZE[0] / 2.0, 0.0, 0.0))
    panel = Panel(SPEC)
    settle(panel, np.array((0.0, 0.0, -0.8 * WEIGHT)), end)
    assert abs(panel.body.rotation[2, 0]) < 0.03
    settle(panel, np.array((0.0, 0.0, -1.3 * WEIGHT)), end, 0.5)
    assert abs(panel.body.rotation[2, 0]) > 0.1


@pytest.mark.parametrize(
    "rotation",
    [np.eye(3), rotation_from_vector((math.pi / 2, 0, 0)), rotation_from_vector((0, math.pi / 2, 0))],
    ids=["flat", "on its long edge", "on its short edge"],
)
def test_the_foam_is_as_stiff_as_asked(rotation: np.ndarray) -> None:
    panel = on_the_ground(rotation)
    before = panel.body.position[2]
    assert np.abs(rotation[2]) @ SIZE / 2.0 - before == pytest.approx(WEIGHT / SPEC.stiffness, rel=1e-3)
    settle(panel, np.array((0.0, 0.0, -10.0)))
    assert 10.0 / (before - panel.body.position[2]) == pytest.approx(SPEC.stiffness, rel=1e-3)


def test_it_slides_when_the_push_exceeds_friction_and_not_before() -> None:
    panel = on_the_ground(np.eye(3))
    start = panel.body.position[0]
    settle(panel, np.array((0.95 * SPEC.friction * WEIGHT, 0.0, 0.0)))
    assert panel.body.position[0] - start < 3e-3
    settle(panel, time=1.0)
    assert panel.body.position[0] - start < 1e-4
    push = 1.2 * SPEC.friction * WEIGHT
    for _ in range(500):
        panel.step(np.array((push, 0.0, 0.0)), NOTHING, STEP)
    assert panel.body.velocity[0] == pytest.approx(0.2 * SPEC.friction * GRAVITY, rel=0.05)


def test_it_falls_over_and_comes_to_rest() -> None:
    panel = on_the_ground(np.eye(3))
    panel.body.rotation = rotation_from_vector((math.radians(80), 0, 0))
    panel.body.position = np.array((1.0, 0.0, 0.32))
    settle(panel, time=4.0)
    assert panel.body.position[2] == pytest.approx(SIZE[2] / 2.0, abs=5e-3)
    assert np.linalg.norm(panel.body.spin) < 1e-3


def test_the_supports_are_taken_away_once_it_is_lifted() -> None:
    panel = Panel(SPEC)
    settle(panel, np.array((0.0, 0.0, 1.5 * WEIGHT)), time=0.5)
    assert not panel.supported
    settle(panel, time=4.0)
    assert panel.body.position[2] < 0.03


@pytest.mark.parametrize(("lifted", "stand"), [(0.04, True), (0.06, False)])
def test_they_are_taken_away_before_it_can_hit_them_when_it_is_turned(lifted: float, stand: bool) -> None:
    panel = Panel(SPEC)
    panel.body.position[2] += lifted
    panel.step(np.array((0.0, 0.0, WEIGHT)), np.zeros(3), STEP)
    assert panel.supported == stand


def test_a_free_body_keeps_energy_and_angular_momentum() -> None:
    inertia = np.array((0.05, 0.18, 0.22))
    body = RigidBody(1.5, inertia, np.zeros(3), np.eye(3))
    body.spin = np.array((3.0, 0.1, 0.05))
    lift = np.array((0.0, 0.0, WEIGHT))

    def momentum() -> np.ndarray:
        return body.rotation @ (inertia * (body.rotation.T @ body.spin))

    start = momentum()
    for _ in range(500):
        body.step(lift, NOTHING, STEP)
    assert momentum() == pytest.approx(start, abs=0.02 * np.linalg.norm(start))
    assert body.rotation @ body.rotation.T == pytest.approx(np.eye(3), abs=1e-9)
    assert body.position == pytest.approx((0, 0, 0), abs=1e-9)
