from __future__ import annotations

import copy

import pytest

from tests.replay import columns, expectations
from tests.replay.cases import Case, cases
from tests.replay.player import Answers, Said, digests, play
from tests.replay.recordings import INPUTS, load

CASES = {case.name: case for case in cases()}
MOST_BYTES = 600_000
"""Of all recordings together, and of all expectations: whoever clones the repository takes them along for good."""


@pytest.fixture(scope="module")
def short() -> Answers:
    return play(CASES["load-paper"])


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_services_answer_recorded_inputs_as_expected(case: Case) -> None:
    expected = expectations.load(expectations.path_of(case))

    problem = expectations.told(expectations.differences(case.name, expected, play(case)))

    assert not problem, problem


def test_every_expectation_is_of_a_case() -> None:
    assert {path.stem for path in expectations.EXPECTED.iterdir()} == set(CASES)


def test_files_stay_small() -> None:
    assert sum(path.stat().st_size for path in INPUTS.iterdir()) < MOST_BYTES
    assert all(path.stat().st_size < MOST_BYTES / 2 for path in expectations.EXPECTED.iterdir())


def test_two_replays_are_alike_to_the_last_bit(short: Answers) -> None:
    assert digests(play(CASES["load-paper"])) == digests(short)


@pytest.mark.parametrize(
    ("key", "number", "field", "value"),
    [
        ("command/ee_twist", 1230, "linear", [1e-8, 0.0, 0.0]),
        ("control/status", 1231, "state", "braking"),
        ("wrench/external", 7, "valid", False),
        ("health/controller", 3, "overruns", 1),
        ("wrench/external", 12, "fault", None),
    ],
)
def test_a_changed_answer_is_named(short: Answers, key: str, number: int, field: str, value: object) -> None:
    changed = copy.deepcopy(short)
    time, content = changed[key][number]
    changed[key][number] = Said(time, {**content, field: value})

    said = expectations.told(expectations.differences("case", expectations.reduced(short), changed))

    assert f"case: {key}, message {number} at {time * 1e-9:.4f} s: {field}" in said
    assert expectations.ANEW in said
    assert digests(changed)[key] != digests(short)[key]


def test_a_late_a_missing_and_an_additional_message_are_named(short: Answers) -> None:
    key = "control/status"
    first, second, *rest = short[key]
    late = {**short, key: [first, second._replace(time=second.time + 1), *rest]}
    missing = {**short, key: [first, second, *rest[:-1]]}
    additional = {**short, "command/head": [first]}

    def said(answers: Answers) -> str:
        return expectations.told(expectations.differences("case", expectations.reduced(short), answers))

    assert "(heard)" in said(late)
    assert f"{key}: {len(short[key]) - 1} messages, wanted {len(short[key])}" in said(missing)
    assert "command/head: 1 messages, wanted 0" in said(additional)
    assert not said(short)


def test_messages_survive_being_stored_in_columns() -> None:
    messages = [
        {"a": 1, "b": [0.1, -2.5e-17], "c": {"d": None, "e": {}, "f": []}, "g": "text", "h": True},
        {"a": -(2**62), "b": [float("inf"), -0.0, 3.0], "data": b"bytes", "h": False},
        {},
    ]

    rows = columns.unpack(columns.pack([columns.leaves(one) for one in messages], lambda place: None))

    assert [columns.build(row) for row in rows] == messages


def test_a_recording_is_in_order_and_keeps_quaternions_of_unit_norm() -> None:
    for name in ("carry", "load"):
        events = load(INPUTS / f"{name}.xz")
        assert [event.time for event in events] == sorted(event.time for event in events)
        norms = [
            sum(part**2 for part in event.content["orientation"]) ** 0.5
            for event in events
            if "orientation" in event.content
        ]
        assert max(abs(norm - 1.0) for norm in norms) < 1e-5
