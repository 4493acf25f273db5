"""The judge passes good runs and fails each defective one for the right reason."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from services.experiment.load.load import LOAD
from services.experiment.load.load_claims import judge
from services.experiment.load.load_measures import measure, reversals
from services.experiment.load.load_protocol import RUNS
from services.experiment.play.course import Run
from tests.services.experiment.load.synthetic import Defect, recording


def failed(run: Run, defect: Defect | None = None) -> list[str]:
    claims = judge({run.name: run}, {run.name: measure(recording(run, defect))})
    assert claims
    return [claim.text for claim in claims if not claim.passed]


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_a_good_run_passes_every_claim(run: Run) -> None:
    assert failed(run) == []


@pytest.mark.parametrize(
    ("defect", "words"),
    [
        (Defect(sag_under_light=0.02), "holds 20 N"),
        (Defect(force_x=26.0), "stays within every limit"),
        (Defect(holds_heavy=True), "lowers the heavier bag to the ground"),
        (Defect(bounces=0.03), "lowers it smoothly"),
        (Defect(keeps_pressing=2.0), "the load is within limit"),
        (Defect(swings=3.0), "carries it steadily"),
        (Defect(stays_low=0.05), "comes back"),
    ],
    ids=[
        "sags",
        "pushed sideways",
        "never lowers",
        "bounces",
        "keeps pressing",
        "swings",
        "does not come back",
    ],
)
def test_a_defect_fails_its_claim(defect: Defect, words: str) -> None:
    assert any(words in text for text in failed(LOAD.run_named("certified-100"), defect))


def steady(defect: Defect) -> tuple[str, bool]:
    run = LOAD.run_named("certified-100")
    claims = judge({run.name: run}, {run.name: measure(recording(run, defect))})
    return next((claim.figure, claim.passed) for claim in claims if "carries it steadily" in claim.text)


def test_a_load_that_swings_after_a_brake_is_steady_and_the_brake_is_told() -> None:
    figure, passed = steady(Defect(braked_at=18.2))
    assert passed
    assert re.fullmatch(r"±0\.\d\d N, 1 brake: no fresh command", figure)


def test_the_same_swing_without_a_brake_is_none_the_law_is_excused_for() -> None:
    figure, passed = steady(Defect(braked_at=18.2, told_brake=False))
    assert not passed
    assert "brake" not in figure


def test_a_load_that_swings_beside_a_brake_fails_all_the_same() -> None:
    figure, passed = steady(Defect(braked_at=18.2, swings=3.0))
    assert not passed
    assert figure.endswith("1 brake: no fresh command")


def test_where_brakes_leave_too_little_to_judge_the_claim_fails() -> None:
    run = LOAD.run_named("certified-100")
    found = dataclasses.replace(measure(recording(run)), judged_way=0.1, load_swing=0.1)
    claims = judge({run.name: run}, {run.name: found})
    assert [(claim.figure, claim.passed) for claim in claims if "steadily" in claim.text] == [
        ("too little without brakes", False)
    ]


def test_a_baseline_that_holds_the_bag_fails_the_claim_that_it_sags() -> None:
    stiff = dataclasses.replace(LOAD.run_named("certified-100"), law="stiffness")
    found = measure(recording(LOAD.run_named("certified-100")))
    claims = judge({stiff.name: stiff}, {stiff.name: found})
    assert [claim.text for claim in claims if not claim.passed] == [
        "the baseline cannot hold 20 N: it sags by decimetres"
    ]


def test_the_comparison_follows_the_figures_not_the_names() -> None:
    paper, certified = LOAD.run_named("paper-30"), LOAD.run_named("certified-30")
    runs = {paper.name: paper, certified.name: certified}
    found = measure(recording(paper))
    for factor, passed in ((0.5, True), (1.5, False)):
        better = {
            name: factor * getattr(found, name) for name in ("load_swing", "ground_peak", "ground_ripple")
        }
        measured = {paper.name: found, certified.name: dataclasses.replace(found, **better)}
        claims = [claim for claim in judge(runs, measured) if claim.run == "certified-30, paper-30"]
        assert [claim.passed for claim in claims] == [passed] * 3


def test_figures_are_those_of_the_model() -> None:
    found = measure(recording(LOAD.run_named("certified-100")))
    assert found.hold_height == pytest.approx(1.0, abs=1e-3)
    assert found.hold_error < 1e-3
    assert found.peak_speed == pytest.approx(0.15, abs=0.01)
    assert found.drop == pytest.approx(0.38, abs=0.02)
    assert found.landing == pytest.approx(17.0 + 0.38 / 0.15, abs=0.3)


def test_a_recording_that_stopped_early_is_refused_by_name() -> None:
    short = recording(LOAD.run_named("paper-30"))
    short.events = short.events[:1]
    with pytest.raises(ValueError, match=r"paper-30.*'heavy'"):
        measure(short)


def test_reversals_count_turns_beyond_the_threshold_only() -> None:
    line = np.linspace(1.0, 0.0, 500)
    ripple = 0.4 * np.sin(np.linspace(0, 40, 500))
    assert reversals(line, 0.01) == 0
    assert reversals(line + 0.01 * ripple, 0.01) == 0
    assert reversals(line + ripple, 0.01) >= 10
    assert reversals(np.array([]), 0.01) == 0
