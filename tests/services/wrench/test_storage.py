"""Files: what was written comes back, anything else is refused in one line that names it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from services.wrench.compensation import Compensation
from services.wrench.identification import identify
from services.wrench.storage import Journal, JournalEntry, load_payload, save_payload
from shared.parameters import Refused
from tests.services.wrench.sensor import LEVEL, TILTED, Sensor

TARED = Compensation().tared(np.arange(6.0), 0.1 * np.ones(6), 0.5 * np.ones(6), LEVEL)
ENTRY = JournalEntry("", TARED, since=12)


def test_payload_comes_back_as_it_was(tmp_path: Path) -> None:
    sensor, path = Sensor(), tmp_path / "new" / "payload.toml"
    result = identify([sensor.average(rotation) for rotation in TILTED])
    save_payload(path, result)
    again = load_payload(path)
    assert again.mass == result.mass
    assert np.array_equal(again.com, result.com)
    assert np.array_equal(again.compensation().bias_error, result.compensation().bias_error)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("mass = ", "weight = ", "mass is missing"),
        ("mass = ", "mass = -", "wanted more than 0 kg"),
        ("mass = ", 'mass = "heavy" # ', "mass is 'heavy', wanted a number"),
        ("com = [", "com = [0.0, ", "com has 4 elements, wanted 3"),
        ("com = [", "com = [nan, 0.0, 0.0] # ", "com is nan, wanted a finite number"),
        ("noise = [", "noise = [-1.0, 1, 1, 1, 1, 1] # ", "wanted every element at least 0 N, Nm"),
        ("com = [", "com = ", "not TOML"),
        ("mass = ", "mass = " + "[" * 5000 + "#", "not TOML"),
        ("com = [", "com = [1.7e308, 1.7e308, 1.7e308] # ", "wanted a finite number"),
    ],
)
def test_bad_payload_file_is_refused(tmp_path: Path, old: str, new: str, reason: str) -> None:
    sensor, path = Sensor(), tmp_path / "payload.toml"
    save_payload(path, identify([sensor.average(rotation) for rotation in TILTED]))
    path.write_text(path.read_text().replace(f"\n{old}", f"\n{new}", 1))
    with pytest.raises(Refused, match=reason) as refusal:
        load_payload(path)
    assert str(path) in str(refusal.value)


def test_missing_payload_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="No such file"):
        load_payload(tmp_path / "none.toml")


def test_journal_keeps_the_newest_few_runs(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "wrench.json")
    for session in range(20):
        journal.record(session, ENTRY)
    assert journal.recall(3, "") is None
    recalled = journal.recall(19, "")
    assert recalled is not None and recalled.to_plain() == ENTRY.to_plain()


def test_journal_of_another_configuration_is_not_used(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "wrench.json")
    journal.record(1, ENTRY)
    assert journal.recall(1, "payload.toml") is None


@pytest.mark.parametrize(
    "content",
    [
        "",
        "garbage",
        "[]",
        "[" * 100_000,
        '{"1": 3}',
        '{"1": {"payload": "", "compensation": {"kind": "tare", "bias": [1.0]}}}',
    ],
)
def test_broken_journal_is_ignored(tmp_path: Path, content: str) -> None:
    path = tmp_path / "wrench.json"
    path.write_text(content)
    journal = Journal(path)
    assert journal.recall(1, "") is None
    journal.record(1, ENTRY)
    assert journal.recall(1, "") is not None
    assert json.loads(path.read_text())["1"]["compensation"]["kind"] == "tare"
