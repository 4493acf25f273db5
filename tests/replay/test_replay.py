"""The services answer as they did when the golden recordings were made."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from services.experiment.replay.equality import equality, told
from services.experiment.replay.recorded import read
from services.experiment.replay.replay import replay
from tests.replay.cases import Case, cases
from tests.replay.compare import lines
from tests.replay.events import events
from tests.replay.record import HEARD, RECORDINGS, said_by_others, write

CASES = {case.name: case for case in cases()}
REPLAYS = [(case, service) for case in CASES.values() for service in case.services]
NEAR = 1e-9  # relative and absolute: another processor adds up in another order
MOST_BYTES = 1_000_000
"""Of each recording: whoever clones the repository takes it along for good."""
ANEW = "If the change is meant: python -m tests.replay expect, and say why in the commit."


@pytest.mark.slow
@pytest.mark.parametrize(("case", "service"), REPLAYS, ids=[f"{case.name}-{service}" for case, service in REPLAYS])
def test_a_service_answers_as_it_did(case: Case, service: str) -> None:
    found = read([RECORDINGS / f"{case.name}.mcap"], service)
    restarts = sum(restarted == service for _, restarted in case.restarts)
    assert len(found.lives) == 1 + restarts
    for life in found.lives:
        compared = equality(life, replay(found, life, {}), NEAR)
        assert compared.equal == compared.compared > 100, "\n".join([*told(service, compared), ANEW])
        assert life.whole and not compared.missing and not compared.gaps


def test_every_recording_is_of_a_case_and_small() -> None:
    assert {path.stem for path in RECORDINGS.iterdir()} == set(CASES)
    assert all(path.stat().st_size < MOST_BYTES for path in RECORDINGS.iterdir())


def test_made_anew_what_was_said_to_the_services_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By `expect`: answers may become others, what the robot said and people asked may not."""
    monkeypatch.setattr("tests.replay.record.RECORDINGS", tmp_path)
    case = CASES["load-faults"]
    given = said_by_others(case, events(RECORDINGS / "load-faults.mcap", HEARD))
    assert sum(event.asked for event in given) >= sum(edit["do"] == "ask" for edit in case.edits) > 0
    write(case, given)
    again = said_by_others(case, events(tmp_path / "load-faults.mcap", HEARD))
    assert list(map(repr, again)) == list(map(repr, given))


def test_a_checksum_tells_one_answer_from_another(tmp_path: Path) -> None:
    shutil.copy(RECORDINGS / "load-faults.mcap", tmp_path)
    first, *rows = lines(tmp_path)
    assert first.startswith("sources in ")
    assert {row.split("\t")[1] for row in rows} == {
        "wrench 1 wrench/external",
        "controller 1 command/ee_twist",
        "controller 1 control/status",
    }
    assert len({row.split("\t")[2] for row in rows}) == 3
    assert [*lines(tmp_path)][1:] == rows
