"""The contact world against what physics says about it: energy, statics, friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.contact.elastic import Spring, Surface
from benchmarks.contact.robot import Robot
from benchmarks.contact.world import Contact, World
from shared.spatial import Array, rotation_from_vector, wrench_about
from tests.services.controller.contacts import jacobian

START = np.array((0.4, -0.2, 0.9)), rotation_from_vector((0.2, -0.4, 0.7))


def smooth_path(seed: int, samples: int, closed: bool) -> tuple[Array, Array, Array, Array]:
    """A smooth path of poses and its twists at the middle of each step: positions, rotations, twists, step."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 1.0, samples + 1)
    waves = rng.normal(size=(3, 6)) * 0.02
    shape = np.stack([np.sin(2 * np.pi * n * time) if closed else np.sin(n * time) for n in (1, 2, 3)], axis=1)
    offsets = shape @ waves
    positions = START[0] + offsets[:, :3]
    rotations = np.array([rotation_from_vector(4.0 * vector) @ START[1] for vector in offsets[:, 3:]])
    turns = Rotation.from_matrix(rotations[1:] @ rotations[:-1].transpose(0, 2, 1)).as_rotvec()
    moves = np.hstack((np.diff(positions, axis=0), turns))
    return positions, rotations, moves, time


def random_contacts(seed: int, friction: float) -> tuple[Contact, ...]:
    """Three loaded contacts of every kind."""
    rng = np.random.default_rng(seed)
    contacts = []
    for carried in (True, False):
        arm = rng.uniform(-0.3, 0.3, 3)
        point = arm if carried else START[0] + START[1] @ arm
        here = START[0] + START[1] @ arm if carried else arm
        root = rng.normal(size=(3, 3))
        contacts.append(Contact(point, carried, Spring(root @ root.T * 100.0, here + rng.normal(size=3) * 0.01)))
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        surface = Surface(normal, here + normal * 0.01, 800.0, 500.0, friction)
        contacts.append(Contact(point, carried, surface))
    return tuple(contacts)


def work(contacts: tuple[Contact, ...], seed: int, samples: int, closed: bool = True) -> float:
    """Work [J] that the contacts do on the tool along a path."""
    positions, rotations, moves, _ = smooth_path(seed, samples, closed)
    world = World(contacts, positions[0], rotations[0])
    wrenches = world.advance(positions, rotations, np.zeros((samples + 1, 3)))
    return float(np.einsum("ij,ij->", (wrenches[1:] + wrenches[:-1]) / 2.0, moves))


@pytest.mark.parametrize("seed", range(6))
def test_closed_path_without_friction_does_no_net_work(seed: int) -> None:
    contacts = random_contacts(seed, friction=0.0)
    scale = abs(work(contacts, seed, 500, closed=False))
    assert scale > 1e-2, "the path must be one along which the contacts work"
    assert abs(work(contacts, seed, 4000)) < 1e-3 * scale


@pytest.mark.parametrize("seed", range(6))
def test_closed_path_with_friction_dissipates(seed: int) -> None:
    assert work(random_contacts(seed, friction=0.6), seed, 3000) < -1e-4


def test_single_spring_follows_hooke() -> None:
    position, rotation = START
    arm = np.array((0.1, 0.2, -0.3))
    anchor = position + rotation @ arm
    world = World((Contact(arm, True, Spring(300.0 * np.eye(3), anchor)),), position, rotation)
    moved = np.array((0.01, -0.02, 0.005))
    wrench = world.advance((position + moved)[None], rotation[None], np.zeros((1, 3)))[0]
    force = -300.0 * moved
    np.testing.assert_allclose(wrench[:3], force, rtol=1e-12)
    np.testing.assert_allclose(wrench[3:], np.cross(rotation @ arm, force), rtol=1e-12)


def test_both_kinds_of_contact_agree_while_nothing_turns() -> None:
    position, rotation = START
    arm = rotation.T @ np.array((0.1, 0.2, -0.3))
    here = position + rotation @ arm
    normal = np.array((0.0, 0.6, 0.8))
    carried = Contact(arm, True, Surface(normal, here, 500.0))
    # The same plane seen from the other side: its outward normal is the opposite, in tool axes.
    fixed = Contact(here, False, Surface(rotation.T @ -normal, arm, 500.0))
    path = position + np.linspace(0.0, 0.02, 20)[:, None] * np.array((0.3, -0.4, -0.6))
    still = np.tile(rotation, (20, 1, 1))
    wrenches = [World((c,), position, rotation).advance(path, still, np.zeros((20, 3))) for c in (carried, fixed)]
    assert np.abs(wrenches[0]).max() > 1.0
    np.testing.assert_allclose(wrenches[0][:, :3], wrenches[1][:, :3], atol=1e-9)
    # The environment's point stays behind while the tool moves on: the arm differs by the motion.
    moved = np.cross(path - position, wrenches[0][:, :3])
    np.testing.assert_allclose(wrenches[0][:, 3:], wrenches[1][:, 3:] + moved, atol=1e-9)


def test_wrench_transports_to_another_origin() -> None:
    position, rotation = START
    contacts = random_contacts(3, friction=0.0)
    wrench = World(contacts, position, rotation).advance(position[None], rotation[None], np.zeros((1, 3)))[0]
    offset = rotation @ np.array((0.2, -0.1, 0.4))
    shift = rotation.T @ offset
    moved = tuple(Contact(c.point - shift if c.carried else c.point, c.carried, _relative(c, shift)) for c in contacts)
    other = World(moved, position + offset, rotation)
    elsewhere = other.advance((position + offset)[None], rotation[None], np.zeros((1, 3)))[0]
    np.testing.assert_allclose(wrench_about(wrench, -offset), elsewhere, atol=1e-9)


def _relative(contact: Contact, offset: Array) -> Spring | Surface:
    """The law of a contact after the tool origin moved by ``offset`` (3,) in tool axes."""
    law = contact.law
    if contact.carried:
        return law
    return replace(law, rest=law.rest - offset) if isinstance(law, Spring) else replace(law, origin=law.origin - offset)


@pytest.mark.parametrize("seed", range(4))
def test_friction_stays_in_its_cone_and_sticks_below(seed: int) -> None:
    rng = np.random.default_rng(seed)
    surface = Surface(np.array((0.0, 0.0, 1.0)), np.zeros(3), 1000.0, 700.0, 0.4)
    path = np.cumsum(rng.normal(size=(2000, 3)) * (4e-4, 4e-4, 2e-5), axis=0) - (0.0, 0.0, 0.005)
    contact = Contact(np.zeros(3), True, surface)
    world = World((contact,), path[0], np.eye(3))
    force = world.advance(path, np.tile(np.eye(3), (2000, 1, 1)), np.zeros((2000, 3)))[:, :3]
    sideways = np.linalg.norm(force[:, :2], axis=1)
    assert np.all(sideways <= 0.4 * force[:, 2] + 1e-9)
    assert np.any(sideways > 0.4 * force[:, 2] - 1e-9), "the path must also slip"
    sticking = sideways[1:] < 0.4 * force[1:, 2] - 1e-6
    expected = force[:-1, :2] - 700.0 * np.diff(path[:, :2], axis=0)
    np.testing.assert_allclose(force[1:, :2][sticking], expected[sticking], atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_wrench_is_incremental(seed: int) -> None:
    """Walking the path in one go or in pieces is the same, and finer samples converge."""
    contacts = random_contacts(seed, friction=0.5)
    ends = []
    for samples, pieces in ((400, 1), (400, 7), (6400, 1)):
        positions, rotations, _, _ = smooth_path(seed, samples, closed=False)
        world = World(contacts, positions[0], rotations[0])
        for part in np.array_split(np.arange(samples + 1), pieces):
            wrenches = world.advance(positions[part], rotations[part], np.zeros((len(part), 3)))
        ends.append(wrenches[-1])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
    np.testing.assert_allclose(ends[0], ends[2], atol=0.02 * np.abs(ends[2]).max())


def test_one_sided_surface_only_pushes_and_moving_environment_counts() -> None:
    contact = Contact(np.zeros(3), True, Surface(np.array((0.0, 0.0, 1.0)), np.zeros(3), 1000.0))
    world = World((contact,), np.array((0.0, 0.0, 0.01)), np.eye(3))
    still, turned = np.zeros((5, 3)), np.tile(np.eye(3), (5, 1, 1))
    above = np.tile((0.0, 0.0, 0.01), (5, 1))
    assert np.all(world.advance(above, turned, still) == 0.0)
    lifted = np.linspace(0.0, 0.02, 5)[:, None] * np.array((0.0, 0.0, 1.0))
    np.testing.assert_allclose(world.advance(above, turned, lifted)[:, 2], [0.0, 0.0, 0.0, 5.0, 10.0], atol=1e-9)


@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_robot_travels_what_was_commanded_and_no_more(lag: float) -> None:
    robot = Robot(np.zeros(3), np.eye(3), lag)
    twist = np.array((0.1, -0.2, 0.05, 0.3, 0.2, -0.4))
    robot.command(0.01, twist, 0.03)
    path = robot.advance(0.0, 1.0, 1e-3)
    np.testing.assert_allclose(path.positions[-1], twist[:3] * 0.03, rtol=1e-9)
    np.testing.assert_allclose(path.rotations[-1], rotation_from_vector(twist[3:] * 0.03), atol=1e-12)
    assert np.all(np.diff(path.positions[:, 0]) >= 0.0), "a lag never overshoots"
    before = path.positions[path.times <= 0.01 + 1e-12]
    assert np.all(before == 0.0), "nothing acts before its delay"
    np.testing.assert_allclose(robot.travelled, (np.linalg.norm(twist[:3]) * 0.03, np.linalg.norm(twist[3:]) * 0.03))


def test_robot_composes_rotations_in_their_order() -> None:
    robot = Robot(np.zeros(3), np.eye(3), 0.0)
    first, second = np.array((0.0, 0.0, 0.0, 2.0, 0.0, 0.0)), np.array((0.0, 0.0, 0.0, 0.0, 3.0, 0.0))
    robot.command(0.0, first, 1.0)
    robot.command(0.5, second, 1.0)
    robot.advance(0.0, 1.0, 0.01)
    expected = rotation_from_vector((0.0, 1.5, 0.0)) @ rotation_from_vector((1.0, 0.0, 0.0))
    np.testing.assert_allclose(robot.rotation, expected, atol=1e-12)


def test_measured_tangent_is_the_springs() -> None:
    position, rotation = START
    arm = np.array((0.1, 0.2, -0.3))
    at = position + rotation @ arm
    world = World((Contact(arm, True, Spring(300.0 * np.eye(3), at)),), position, rotation)
    J = jacobian(rotation @ arm)
    tangent = world.stiffness(position, rotation, np.zeros(3))
    np.testing.assert_allclose(tangent, 300.0 * J.T @ J, atol=1e-3)
