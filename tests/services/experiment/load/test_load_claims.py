"""The judge passes a good run (every law: tests/system/test_load.py) and fails each defective one for its reason."""

from __future__ import annotations

import copy
import dataclasses
import re

import numpy as np
import pytest

from services.experiment.load.load import LOAD
from services.experiment.load.load_claims import judge
from services.experiment.load.load_measures import Measures, measure, reversals
from services.experiment.measure.claim import Claim
from services.experiment.play.recording import Recording
from tests.services.experiment.load import defects
from tests.services.experiment.load.defects import Defect

RUN = LOAD.run_named("certified-100")


def spoilt(played: Recording, *spoil: Defect) -> Measures:
    recording = copy.deepcopy(played)
    for defect in spoil:
        defect(recording)
    return measure(recording)


def claims(found: Measures, law: str = RUN.law) -> list[Claim]:
    return judge({RUN.name: dataclasses.replace(RUN, law=law)}, {RUN.name: found})


def failed(found: Measures, law: str = RUN.law) -> list[str]:
    return [claim.text for claim in claims(found, law) if not claim.passed]


@pytest.mark.parametrize(
    ("defect", "words"),
    [
        (defects.sags, "holds 20 N"),
        (defects.pushed_sideways, "stays within every limit"),
        (defects.never_lowers, "lowers the heavier bag to the ground"),
        (defects.bounces, "lowers it smoothly"),
        (defects.keeps_pressing, "the load is within limit"),
        (defects.swings, "carries it steadily"),
        (defects.stays_low, "comes back"),
    ],
)
def test_a_defect_fails_its_claim_and_the_good_run_none(played: Recording, defect: Defect, words: str) -> None:
    assert failed(measure(played)) == []
    assert any(words in text for text in failed(spoilt(played, defect)))


@pytest.mark.parametrize(
    ("defect", "figure", "passed"),
    [
        (defects.braked, r"±0\.\d\d N, 3 brakes: no fresh command", True),
        (defects.swings_now_and_then, r"±\d\.\d\d N", False),
        (defects.braked_and_swings, r"±\d\.\d\d N, 3 brakes: no fresh command", False),
    ],
    ids=["after brakes", "without brakes", "beside brakes"],
)
def test_a_load_may_swing_after_brakes_which_are_told_and_at_no_other_time(
    played: Recording, defect: Defect, figure: str, passed: bool
) -> None:
    (steady,) = (claim for claim in claims(spoilt(played, defect)) if "carries it steadily" in claim.text)
    assert steady.passed == passed
    assert re.fullmatch(figure, steady.figure)


def test_where_brakes_leave_too_little_to_judge_the_claim_fails(played: Recording) -> None:
    found = dataclasses.replace(measure(played), judged_way=0.1, load_swing=0.1)
    (steady,) = (claim for claim in claims(found) if "steadily" in claim.text)
    assert (steady.figure, steady.passed) == ("too little without brakes", False)


def test_a_baseline_that_holds_the_bag_fails_the_claim_that_it_sags(played: Recording) -> None:
    assert failed(measure(played), "stiffness") == ["the baseline cannot hold 20 N: it sags by decimetres"]


def test_the_comparison_follows_the_figures_not_the_names(played: Recording) -> None:
    found = measure(played)
    names = ("paper-30", "certified-30")
    for factor, passed in ((0.5, True), (1.5, False)):
        other = {name: factor * getattr(found, name) for name in ("load_swing", "ground_peak", "ground_ripple")}
        measured = dict(zip(names, (found, dataclasses.replace(found, **other)), strict=True))
        compared = judge({name: LOAD.run_named(name) for name in names}, measured)
        assert [claim.passed for claim in compared if claim.run == "certified-30, paper-30"] == [passed] * 3


def test_figures_are_what_was_done_to_the_recording(played: Recording) -> None:
    good, found = measure(played), spoilt(played, defects.sags, defects.stays_low, defects.keeps_pressing)
    assert good.hold_height == pytest.approx(1.0, abs=1e-3) and good.hold_error < 1e-3
    assert good.drop / good.lowering_time < good.peak_speed < 0.2
    assert found.hold_error == pytest.approx(0.02, abs=1e-3) and found.sag == pytest.approx(0.02, abs=1e-3)
    assert found.return_error == pytest.approx(0.05, abs=0.01)
    assert found.ground_peak == pytest.approx(27.0)


def test_a_recording_that_stopped_early_is_refused_by_name(played: Recording) -> None:
    with pytest.raises(ValueError, match=r"certified-100.*'heavy'"):
        spoilt(played, defects.broken_off)


def test_reversals_count_turns_beyond_the_threshold_only() -> None:
    line = np.linspace(1.0, 0.0, 500)
    ripple = 0.4 * np.sin(np.linspace(0, 40, 500))
    assert reversals(line, 0.01) == 0
    assert reversals(line + 0.01 * ripple, 0.01) == 0
    assert reversals(line + ripple, 0.01) >= 10
    assert reversals(np.array([]), 0.01) == 0
