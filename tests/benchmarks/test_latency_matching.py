"""Which answer belongs to which sample, when some are late, lost or unasked for."""

from __future__ import annotations

from benchmarks.latency.pacing import answers

PERIOD, LATENCY = 10_000_000, 800_000
PUTS = [number * PERIOD for number in range(100)]
ARRIVALS = [put + LATENCY for put in PUTS]


def test_each_sample_has_its_answer() -> None:
    assert answers(PUTS, ARRIVALS) == [800.0] * 100


def test_a_burst_belongs_to_the_samples_that_waited_for_it() -> None:
    arrivals = [*ARRIVALS]
    arrivals[50], arrivals[51] = PUTS[52] + 600_000, PUTS[52] + 700_000
    assert answers(PUTS, arrivals)[49:54] == [800.0, 20_600.0, 10_700.0, 800.0, 800.0]


def test_a_lost_answer_and_an_unasked_one_shift_no_other() -> None:
    arrivals = sorted([*ARRIVALS[:30], *ARRIVALS[31:], PUTS[70] + 5_000_000])
    matched = answers(PUTS, arrivals)
    assert matched[30] is None
    assert all(matched[number] == 800.0 for number in range(100) if number not in (30, 70))
