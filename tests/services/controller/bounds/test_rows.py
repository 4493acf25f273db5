"""The rows' rooms against rules 1, 4, 5 and 6 of the guarantee, written a second time."""

from __future__ import annotations

import numpy as np
import pytest

from services.controller.bounds.contact_zone import ContactZone
from services.controller.bounds.rows import Rows
from services.controller.bounds.stiffness_bound import StiffnessBound
from shared.spatial import rotation_from_vector
from tests.services.controller import closed_form
from tests.services.controller.contacts import LIMIT

T, HORIZON = 0.012, 0.05


def test_rooms_are_the_rules() -> None:
    rng = np.random.default_rng(10)
    bound = StiffnessBound([ContactZone(800.0, (0.5, 0.2, 0.1), 0.4), ContactZone(3000.0, (0.1, 0.1, 0.05))])
    rows = Rows(T, HORIZON)
    opened = np.full((2, 12), np.inf)
    bounded = 0
    for step in range(400):
        if step % 7 == 0:
            bound.update(rotation_from_vector(rng.normal(size=3)), 0.0, (10.0 * rng.random(3)).tolist())
            rows.update(bound)
        M = closed_form.rows(bound.matrix, bound.low)
        cap = np.tile(LIMIT * rng.uniform(0.9, 1.0, 6), 2)
        levels = np.stack((cap, cap, cap - 0.1 * cap))
        wrench, dt = LIMIT * rng.uniform(-1.1, 1.1, 6), T * rng.uniform(0.1, 1.1)
        path = 1e-3 * rng.random(12) * rng.integers(0, 2, 12)
        rows.find(wrench, path, levels, dt)

        left = levels - closed_form.both_senses(wrench)
        largest, own = M.max(axis=1), np.tile(bound.matrix.diagonal(), 2)
        soon = np.maximum(0.0, left[0] - M @ path) / (T * largest)
        lasting = np.maximum(0.0, left[1:]) / (HORIZON * np.stack((largest, own)))
        part = opened + min(1.0, dt / HORIZON) * (lasting - opened) if step else lasting
        opened = np.minimum(lasting, part)
        assert rows.scaled * largest[:, None] == pytest.approx(M)
        assert rows.room == pytest.approx(np.minimum(soon, opened[0]), abs=1e-12)
        assert rows.tightest == rows.room.min()
        assert rows.reserved == pytest.approx(opened[1], abs=1e-12)
        bounded += np.count_nonzero((rows.room > 0.0) & (rows.room < opened[0]))
    assert bounded > 50, "rule 4 has to matter too"
