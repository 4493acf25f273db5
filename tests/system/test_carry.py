"""The carry with all services in simulated time: every claim holds, under every law that claims it, with each base."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.carry.carry import CARRY
from services.experiment.carry.carry_claims import judge
from services.experiment.carry.carry_measures import Measures, measure
from services.experiment.measure.claim import Claim

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
NAMES = (*(run.name for run in CARRY.runs), "certified-differential", "paper-differential")


@cache
def measured(name: str) -> Measures:
    return measure(play_run(CARRY, CARRY.run_named(name)))


def claims(*names: str) -> list[Claim]:
    return judge({name: CARRY.run_named(name) for name in names}, {name: measured(name) for name in names})


def failed(found: list[Claim]) -> list[str]:
    return [f"{claim.run}, {claim.text}: {claim.figure} ({claim.limit})" for claim in found if not claim.passed]


@pytest.mark.parametrize("name", NAMES)
def test_every_claim_holds(name: str) -> None:
    found = claims(name)
    assert len(found) >= 2
    assert failed(found) == []


def test_certified_keeps_limits_better_than_the_paper_s_law_at_no_greater_cost() -> None:
    found = [claim for claim in claims("certified-omni", "paper-omni") if "," in claim.run]
    assert len(found) >= 3
    assert failed(found) == []
