"""The lines of a view that say how much is known."""

from __future__ import annotations

import numpy as np
import pytest

from services.cli.health.view import _load
from shared.messages import ExternalWrench


@pytest.mark.parametrize(
    ("age", "words"),
    [
        (None, "payload, bound 1.1 N, 0.16 Nm"),
        (-1.0, "payload, no zero of this run, bound 1.1 N, 0.16 Nm"),
        (45.0, "payload, zero 45 s old, bound 1.1 N, 0.16 Nm"),
        (725.0, "payload, zero 12 min old, bound 1.1 N, 0.16 Nm"),
    ],
)
def test_the_load_says_how_old_the_zero_is_and_how_well_the_wrench_is_known(age: float | None, words: str) -> None:
    bound = np.array((0.5, 1.1, 0.6, 0.16, 0.1, 0.1))
    assert _load(ExternalWrench(np.ones(3), np.zeros(3), bound, "payload", "", age), None).endswith(words)
