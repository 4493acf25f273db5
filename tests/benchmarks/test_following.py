"""The sets in which the environment moves: all at one rate, and shaken as they say."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.contact.following import MOVING, RATE, SETS, SHAKEN, case, numbers, show


@pytest.mark.parametrize(("group", "cases"), [*((name, 3) for name in MOVING), ("steady pull", 36), ("shaken-2", 3)])
def test_every_case_of_a_set_runs_at_its_rate_and_moves(group: str, cases: int) -> None:
    found = [case(group, number) for number in numbers(group, 3)]
    assert len(found) == cases
    assert all(1.0 / one.timing.period == pytest.approx(RATE) and not one.at_rest for one in found)


@pytest.mark.parametrize("group", SHAKEN)
def test_a_shaken_contact_goes_to_and_fro_as_often_as_it_says_and_ends_where_it_began(group: str) -> None:
    shaken = case(group, 0)
    way = shaken.shift[:, 0]
    turns = np.count_nonzero(np.diff(np.sign(np.diff(way))))
    assert turns == pytest.approx(2.0 * SHAKEN[group] * shaken.shift_times[-1], abs=1)
    assert np.abs(np.diff(way) / np.diff(shaken.shift_times)).max() == pytest.approx(0.2, rel=0.01)
    assert way[-1] == pytest.approx(0.0, abs=1e-9)


def test_the_ratio_to_another_revision_is_that_of_the_same_quantile(capsys: pytest.CaptureFixture[str]) -> None:
    before = {law: {group: [2.0, 4.0, 0.0] for group in SETS} for law in ("certified-rounded", "paper")}
    here = {law: {group: [1.0, 2.0, 0.0] for group in SETS} for law in ("certified-rounded", "paper")}
    show(here, before)
    compared = [line for line in capsys.readouterr().out.splitlines() if line.endswith("times")]
    assert len(compared) == len(SETS) and all(line.endswith("4.00: 0.50 and 0.50 times") for line in compared)
