"""The stiffness bound against random contacts, and where it is attained."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from services.controller.bounds.stiffness_bound import TURN_QUANTUM, ContactZone, StiffnessBound, widened
from shared.spatial import rotation_from_vector
from tests.services.controller.contacts import bound, jacobian, tangent, unit

REACH = (0.7, 0.3, 0.05)


@pytest.mark.parametrize("friction", [0.0, 0.3, 0.6, 1.0])
def test_no_contact_of_any_kind_exceeds_the_bound(friction: float) -> None:
    rng = np.random.default_rng(1)
    Kbar = bound(ContactZone(1000.0, REACH, friction))
    worst, worst_low = 0.0, 0.0
    for _ in range(4000):
        total = np.zeros((6, 6))
        for share in rng.dirichlet(np.ones(rng.integers(1, 4))):
            r = np.array(REACH) * (rng.choice((-1, 1), 3) if rng.random() < 0.5 else rng.uniform(-1, 1, 3))
            J = jacobian(r)
            total += J.T @ tangent(rng, 1000.0 * share, friction) @ J
        worst = max(worst, float((np.abs(total) / Kbar.matrix).max()))
        falling = -total.diagonal()
        assert np.all(falling <= Kbar.low + 1e-9)
        if friction > 0.0:
            worst_low = max(worst_low, float((falling / Kbar.low).max()))
    assert 0.9 < worst <= 1.0 + 1e-12
    assert friction == 0.0 or worst_low > 0.3


def test_every_element_is_attained_without_friction() -> None:
    """``K = u u'`` with u half-way between the columns of J, at a corner of the reach."""
    Kbar = bound(ContactZone(1.0, REACH), turn=-TURN_QUANTUM)
    largest = np.zeros((6, 6))
    for signs in itertools.product((-1, 1), repeat=3):
        J = jacobian(np.array(REACH) * signs)
        for i, j, side in itertools.product(range(6), range(6), (-1, 1)):
            u = J[:, i] / np.linalg.norm(J[:, i]) + side * J[:, j] / np.linalg.norm(J[:, j])
            if np.linalg.norm(u) < 1e-9:
                continue
            u /= np.linalg.norm(u)
            largest[i, j] = max(largest[i, j], abs((J.T @ np.outer(u, u) @ J)[i, j]))
    assert largest == pytest.approx(Kbar.matrix, rel=1e-9)


def test_zones_add_up() -> None:
    far, near = ContactZone(500.0, (1.0, 0.3, 0.1)), ContactZone(5000.0, (0.1, 0.1, 0.05), 0.5)
    both, one, other = bound(far, near), bound(far), bound(near)
    assert both.matrix == pytest.approx(one.matrix + other.matrix)
    assert both.low == pytest.approx(one.low + other.low)


def test_widened_reach_holds_for_every_order_of_turns() -> None:
    rng = np.random.default_rng(2)
    for _ in range(300):
        reach = rng.uniform(0.01, 1.0, 3)
        steps = rng.normal(size=(20, 3))
        turn = np.abs(steps).sum(axis=0).max()
        scale = rng.uniform(0.0, 1.5) / turn
        bounds = np.array(widened(reach.tolist(), turn * scale))
        rotation = np.eye(3)
        for step in steps * scale:
            rotation = rotation_from_vector(step) @ rotation
        corners = np.array(list(itertools.product((-1, 1), repeat=3))) * reach
        assert np.all(np.abs(corners @ rotation.T).max(axis=0) <= bounds + 1e-12)


@pytest.mark.parametrize("fixed_in", ["tool", "environment"])
def test_geometric_part_covers_what_turning_does_to_existing_forces(fixed_in: str) -> None:
    rng = np.random.default_rng(3)
    force_bound = np.array((9.0, 4.0, 7.0))
    Kbar = bound(ContactZone(1.0, REACH), force=tuple(force_bound))
    G = np.array(Kbar.geometric_rows)
    for _ in range(2000):
        r = np.array(REACH) * rng.uniform(-1, 1, 3)
        f = force_bound * rng.uniform(-1, 1, 3)
        twist = rng.normal(size=6)
        v, omega = twist[:3], twist[3:]
        if fixed_in == "tool":  # the arm turns with the tool
            change = np.concatenate((np.zeros(3), np.cross(np.cross(omega, r), f)))
        else:  # the arm shifts, the force turns with the tool's face
            turned = np.cross(omega, f)
            change = np.concatenate((turned, -np.cross(v, f) + np.cross(r, turned)))
        assert np.all(np.abs(change) <= G @ np.abs(twist) + 1e-9)


def test_a_kept_bound_covers_the_attitude_it_is_kept_for() -> None:
    rng = np.random.default_rng(4)
    zones = [ContactZone(800.0, REACH, 0.4)]
    kept = StiffnessBound(zones)
    rotation, turns = np.eye(3), 0.0
    recomputed = 0
    for _ in range(400):
        step = unit(rng) * rng.uniform(0.0, 0.002)
        rotation = rotation_from_vector(step) @ rotation
        turns = 0.02 * rng.random()
        version = kept.version
        kept.update(rotation, turns, [5.0, 5.0, 5.0])
        recomputed += kept.version != version
        exact = StiffnessBound(zones)
        exact.update(rotation, turns - TURN_QUANTUM, [5.0, 5.0, 5.0])
        assert np.all(kept.matrix >= exact.matrix * (1 - 1e-12))
        assert np.all(kept.low >= exact.low * (1 - 1e-12))
    assert 10 < recomputed < 380


def scaled(total: np.ndarray, axes: list[int], scale: np.ndarray) -> float:
    """Largest eigenvalue of ``x^-1 K x^-1`` on some axes."""
    return float(np.linalg.eigvalsh((total / np.outer(scale, scale))[np.ix_(axes, axes)])[-1])


def test_largest_is_the_eigenvalue_at_the_corner_and_no_contact_exceeds_it() -> None:
    rng = np.random.default_rng(2)
    stiffness = 800.0
    Kbar = bound(ContactZone(stiffness, REACH), turn=-TURN_QUANTUM)
    corners = [jacobian(np.array(REACH) * signs) for signs in itertools.product((-1, 1), repeat=3)]
    for _ in range(300):
        axes = sorted(rng.choice(6, rng.integers(1, 7), replace=False).tolist())
        scale = rng.uniform(0.1, 5.0, 6)
        found = Kbar.largest(axes, scale.tolist())
        assert found == pytest.approx(max(scaled(stiffness * J.T @ J, axes, scale) for J in corners), rel=1e-9)
        total = np.zeros((6, 6))
        for share in rng.dirichlet(np.ones(2)):
            J = jacobian(np.array(REACH) * rng.uniform(-1, 1, 3))
            total += J.T @ tangent(rng, stiffness * share, 0.0) @ J
        assert scaled(total, axes, scale) <= found * (1 + 1e-9)


def test_bad_zones_are_refused() -> None:
    with pytest.raises(ValueError, match="contact zone"):
        ContactZone(-1.0, REACH)
    with pytest.raises(ValueError, match="contact zone"):
        ContactZone(1.0, (0.1, float("nan"), 0.1))
    with pytest.raises(ValueError, match="at least one"):
        StiffnessBound([])
