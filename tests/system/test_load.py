"""The load experiment with all services in simulated time: every claim holds, under every law."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.experiment_stack import play_run
from services.experiment.load.load import LOAD
from services.experiment.load.load_claims import judge
from services.experiment.load.load_measures import Measures, measure
from services.experiment.load.load_protocol import FORCE_LIMIT, HEAVY, LIGHT, RUNS, unambiguous
from services.experiment.measure.brakes import NO_COMMAND
from services.experiment.measure.claim import Claim
from services.experiment.play.course import Run
from shared.messages import TwistCommand
from shared.topics import COMMAND_EE_TWIST
from shared.wire.codec import decode
from shared.wire.local import LocalBus

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]


@cache
def measured(name: str) -> Measures:
    return measure(play_run(LOAD, LOAD.run_named(name)))


def claims(*names: str) -> list[Claim]:
    return judge({name: LOAD.run_named(name) for name in names}, {name: measured(name) for name in names})


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_every_claim_holds(run: Run) -> None:
    found = claims(run.name)
    assert len(found) >= 2
    assert [f"{claim.text}: {claim.figure} ({claim.limit})" for claim in found if not claim.passed] == []


def test_certified_is_no_worse_than_the_paper_at_its_rate() -> None:
    found = [claim for claim in claims("paper-30", "certified-30") if claim.run == "certified-30, paper-30"]
    assert len(found) == 3
    assert [f"{claim.text}: {claim.figure}" for claim in found if not claim.passed] == []


def test_the_weights_are_unambiguous_on_both_sides_of_the_limit() -> None:
    for run in RUNS:
        bound = measured(run.name).error_bound
        assert unambiguous(bound) <= HEAVY
        start = run.settings["controller"].get("yield_start", 1.0)
        assert start * (FORCE_LIMIT[2] - bound) > LIGHT


def test_a_higher_rate_and_an_earlier_start_lower_sooner() -> None:
    times = [measured(name).lowering_time for name in ("rounded-100", "certified-100", "certified-30")]
    assert times == sorted(times)


def test_commands_that_are_lost_on_the_way_down_make_a_brake_and_no_swing(monkeypatch: pytest.MonkeyPatch) -> None:
    publish, fast = LocalBus.publish, 0

    def losing(bus: LocalBus, key: str, payload: bytes) -> None:
        nonlocal fast
        if key == COMMAND_EE_TWIST.key:
            fast += decode(TwistCommand, payload)[1].linear[2] < -0.24
            if 60 <= fast < 65:
                return
        publish(bus, key, payload)

    monkeypatch.setattr(LocalBus, "publish", losing)
    run = LOAD.run_named("rounded-100")
    found = measure(play_run(LOAD, run))
    assert [brake.reason for brake in found.brakes] == [NO_COMMAND]
    claims = judge({run.name: run}, {run.name: found})
    assert [f"{claim.text}: {claim.figure} ({claim.limit})" for claim in claims if not claim.passed] == []
    assert found.judged_way < 0.7


def test_the_same_run_twice_gives_the_same_figures() -> None:
    assert measure(play_run(LOAD, LOAD.run_named("paper-30"))) == measured("paper-30")
