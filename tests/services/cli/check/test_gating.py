"""Each rule of the gate that a robot by somebody else does not keep is named."""

from __future__ import annotations

import pytest

from services.cli.check.bench import Bench
from services.cli.check.gating import Gates
from shared.loop.stack import Stack
from tests.services.cli.check.stranger import Stranger


def wrong(breaks: str) -> dict[str, str]:
    stack = Stack(latency=0.001)
    stack.add(Stranger(stack.bus, breaks))
    bench = Bench(stack.bus, stack.scheduler.clock, stack.run)
    bench.wait(0.5)
    rows = Gates(bench, bench.commander(), bench.commander()).rows()
    return {row.what: row.said for row in rows if not row.good}


def test_a_stranger_s_robot_that_keeps_all_rules_passes() -> None:
    assert wrong("") == {}


@pytest.mark.parametrize(
    ("breaks", "what", "said"),
    [
        ("silence", "silence", "still moves"),
        ("ttl", "ttl", "acts for too long"),
        ("invalid", "invalid", "valid: false move the tool"),
        ("sequence", "sequence", "older seq"),
        ("out of sequence named", "sequence", "not named"),
        ("second", "second", "a second session moves the tool"),
        ("second session named", "second", "not named"),
        ("clamping", "clamping", "not clamped"),
        ("clamped named", "clamping", "not named"),
        ("garbage", "garbage", "move the tool"),
        ("rejected named", "garbage", "not named"),
        ("stop", "stop", 'instead of "stopped"'),
        ("moves", "stop", "still moves"),
        ("release", "stop", "valid: false releases"),
        ("releases", "stop", "does not release"),
    ],
)
def test_a_rule_that_is_broken_is_named(breaks: str, what: str, said: str) -> None:
    found = wrong(breaks)
    assert said in found[what], found
    # Who goes on in silence goes on after one command, too.
    assert set(found) == ({what, "ttl"} if breaks == "silence" else {what}), found
