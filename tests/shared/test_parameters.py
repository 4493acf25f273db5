"""Parameters: whatever is set is within its declared range and of its type, or refused in one clear line."""

from __future__ import annotations

import math
from typing import Any, Literal

import pytest
from hypothesis import given, settings

from shared.parameters import Parameters, Refused, Vector3, option, parameter
from tests.shared.strategies import any_plain


class Zone(Parameters):
    stiffness: float = parameter(1000.0, "N/m", 1.0, 1e6, "of the contact")


class Example(Parameters):
    rate: float = parameter(100.0, "Hz", 30.0, 1000.0, "a number")
    limit: Vector3 = parameter((25.0, 25.0, 25.0), "N", 0.1, 100.0, "a vector")
    law: Literal["certified", "paper"] = option("certified", "a choice")
    steps: int = parameter(4, "", 1, 9, "an integer")
    strict: bool = option(True, "a switch")
    zones: tuple[Zone, ...] = option((), "a list of tables")
    low: float = option(0.0, "below high", unit="N")
    high: float = option(1.0, "above low", unit="N")

    def check(self) -> None:
        if self.low >= self.high:
            raise Refused(f"low is {self.low:g}, wanted less than high, {self.high:g}")


def refusal(values: dict[str, Any]) -> str:
    with pytest.raises(Refused) as caught:
        Example.of(values)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 300
    return text


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"rate": 29.9}, "rate is 29.9, allowed is 30 to 1000 Hz"),
        ({"rate": 1001}, "rate is 1001.0, allowed is 30 to 1000 Hz"),
        ({"limit": [25.0, -3.0, 25.0]}, "limit is [25.0, -3.0, 25.0], allowed is 0.1 to 100 N"),
        ({"steps": 0}, "steps is 0, allowed is 1 to 9"),
        ({"zones": [{"stiffness": 0.5}]}, "stiffness is 0.5, allowed is 1 to 1e+06 N/m"),
        ({"low": 2.0}, "low is 2, wanted less than high, 1"),
    ],
)
def test_out_of_range_names_value_and_range(values: dict[str, Any], text: str) -> None:
    assert refusal(values) == text


@pytest.mark.parametrize(
    "values",
    [
        {"rate": "100"},
        {"rate": True},
        {"rate": None},
        {"rate": math.nan},
        {"rate": math.inf},
        {"rate": [100.0]},
        {"rate": 10**400},
        {"limit": 25.0},
        {"limit": [25.0, 25.0]},
        {"limit": [25.0] * 4},
        {"limit": [25.0, "25", 25.0]},
        {"limit": [25.0, math.nan, 25.0]},
        {"law": "stiffness"},
        {"law": 1},
        {"steps": 1.5},
        {"steps": True},
        {"strict": 1},
        {"strict": "yes"},
        {"zones": [{"stiff": 1.0}]},
        {"zones": {"stiffness": 1.0}},
        {"zones": [3]},
    ],
)
def test_a_wrong_type_is_refused_by_name(values: dict[str, Any]) -> None:
    assert next(iter(values)) in refusal(values)


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    text = refusal({"Rate": 100.0})
    assert text.startswith("Rate is no parameter") and "rate, limit, law" in text


def test_names_from_outside_are_shown_short_and_in_one_line() -> None:
    refusal({"x" * 5000: 1.0})
    refusal({"rate\nlimit": 1.0})
    refusal({"rate": "x" * 5000})
    refusal({"rate": "a\nb"})


@settings(max_examples=150, deadline=None)
@given(any_plain)
def test_any_value_is_in_range_or_refused(value: object) -> None:
    for name in ("rate", "limit", "law", "steps", "zones"):
        try:
            chosen = Example.of({name: value})
        except Refused:
            continue
        assert 30.0 <= chosen.rate <= 1000.0
        assert all(0.1 <= element <= 100.0 for element in chosen.limit) and len(chosen.limit) == 3
        assert chosen.law in ("certified", "paper")
        assert 1 <= chosen.steps <= 9 and type(chosen.steps) is int


def test_integers_pass_for_numbers() -> None:
    chosen = Example.of({"rate": 50, "limit": [1, 2, 3]})
    assert chosen.rate == 50.0 and chosen.limit == (1.0, 2.0, 3.0)
    assert type(chosen.rate) is float


def test_a_refused_change_changes_nothing_and_an_accepted_one_the_rest_neither() -> None:
    before = Example.of({"rate": 50.0})
    with pytest.raises(Refused):
        before.changed({"steps": 5, "rate": -1.0})
    after = before.changed({"steps": 5})
    assert (before.steps, after.steps, after.rate) == (4, 5, 50.0)
    with pytest.raises(Exception, match="frozen"):
        after.rate = 60.0  # type: ignore[misc]


def test_the_table_can_travel() -> None:
    table = Example.of({"zones": [{"stiffness": 5.0}]}).table()
    assert table["rate"] == {"value": 100.0, "unit": "Hz", "min": 30.0, "max": 1000.0, "doc": "a number"}
    assert table["low"]["min"] is None and table["low"]["max"] is None
    assert table["limit"]["value"] == [25.0, 25.0, 25.0]
    assert table["zones"]["value"] == [{"stiffness": 5.0}]


def test_a_vector_of_the_wrong_length_is_refused_with_its_name_and_the_length_wanted():
    class Speeds(Parameters):
        limits: Vector3 = parameter((1.0, 1.0, 1.0), "m/s", 0.0, 2.0, "limits")
        place: tuple[float, float] = parameter((0.0, 0.0), "m", -1.0, 1.0, "a place")

    for wrong in ([1.0, 2.0], [1.0] * 4, ["x"] * 3, 3.0):
        with pytest.raises(Refused, match=r"^limits is .*, wanted 3 numbers$"):
            Speeds.of({"limits": wrong})
    with pytest.raises(Refused, match=r"^place is .*, wanted 2 numbers$"):
        Speeds.of({"place": [1.0]})
