"""Latency of the chain `sensor/ft` -> wrench -> controller -> twist received, beside as many hops with nothing in them.

``python -m benchmarks.chain [--quick | --against REV]``. Real processes through a real router, paced at the loop's own
rate; the three transports take turns, so that whatever else the machine does meets all of them alike.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from functools import reduce

from benchmarks import against
from benchmarks.latency import segments
from benchmarks.latency.segments import Segment
from benchmarks.table import Row, at_most, show, shown, skipped

COMMAND = "python -m benchmarks.chain"
RATES = (100.0, 500.0)
LIMIT = 1.3
"""Largest ratio to the bare relay that the chain aims at."""
LINKED = {100.0: 0.92, 500.0: 0.85}
"""Largest ratio of the medians, over direct links to through the router, by rate."""
CLOSED = 1.15
"""Largest ratio of the medians, with mutual TLS and access control to without."""
TOGETHER = 4
"""Robots that share a router."""
OVERRUN_SHARE = 1e-3
"""Largest share of late steps of wrench and controller at 500 Hz."""

Measure = Callable[[float, float], Segment]
_CHAIN = """
import json
from benchmarks.latency import segments

# As `tandem up` starts it: with direct links, where there are any.
measure = getattr(segments, "linked", segments.chain)
found = {}
for rate in (100.0, 500.0):
    chain = measure(rate, 6.0)
    found |= {f"p50 at {rate:.0f} Hz [us]": chain.quantile(0.5), f"p99 at {rate:.0f} Hz [us]": chain.quantile(0.99)}
print(json.dumps(found))
"""


def rows(quick: bool) -> list[Row]:
    """Latency at each rate, and the overruns of 30 s at 500 Hz."""
    table = []
    for rate in RATES:
        table += _compared(rate, *((2, 2.0) if quick else (4, 6.0)))
    table.append(_sustained(RATES[-1], 3.0 if quick else 30.0))
    return [*table, *_beside(RATES[0], *((1, 2.0) if quick else (3, 6.0)))]


def _compared(rate: float, rounds: int, seconds: float) -> list[Row]:
    missing = segments.ros_missing()
    transports: dict[str, Measure] = {
        "chain": segments.chain,
        "linked": segments.linked,
        "closed": segments.closed,
        "relay": segments.relay,
    }
    if not missing:
        transports["ros"] = segments.ros
    turns = [{name: measure(rate, seconds) for name, measure in transports.items()} for _ in range(rounds)]
    total = {name: reduce(Segment.add, (turn[name] for turn in turns), Segment()) for name in transports}
    title = f"chain at {rate:.0f} Hz"
    chain, relay, linked = total["chain"], total["relay"], total["linked"]
    table = [
        *(
            _ratio(
                f"{title}, {name} over direct links to that through the router",
                linked.quantile(share),
                chain.quantile(share),
                limit,
                f"{linked.quantile(share):.0f} us",
            )
            for name, share, limit in (("p50", 0.5, LINKED[rate]), ("p99", 0.99, 0.8))
        ),
        _ratio(
            f"{title}, p50 on a closed network to that on an open one",
            total["closed"].quantile(0.5),
            chain.quantile(0.5),
            CLOSED,
            f"{total['closed'].quantile(0.5):.0f} us, open {chain.quantile(0.5):.0f} us",
        ),
        _against(title, "p50", 0.5, chain, relay),
        _against(title, "p99", 0.99, chain, relay),
        shown(f"{title}, samples without a command", 100 * chain.lost, "%", COMMAND, f"relay {relay.lost:.2%}"),
    ]
    claim = f"{title}, p99 below the rospy relay's"
    if missing:
        return [*table, skipped(claim, missing, COMMAND)]
    ros = total["ros"]
    note = f"rospy, which has no router: p50 {ros.quantile(0.5):.0f}, p99 {ros.quantile(0.99):.0f} us"
    return [*table, _ratio(claim, chain.quantile(0.99), ros.quantile(0.99), 1.0, note)]


def _beside(rate: float, rounds: int, seconds: float) -> list[Row]:
    """What robots that share a router cost each other."""
    alone, beside = Segment(), [Segment() for _ in range(TOGETHER)]
    for _ in range(rounds):
        alone.add(segments.chain(rate, seconds))
        for total, segment in zip(beside, segments.chains(rate, seconds, TOGETHER), strict=True):
            total.add(segment)
    slowest = max(beside, key=lambda segment: segment.quantile(0.5))
    title = f"{TOGETHER} robots at {rate:.0f} Hz at one router"
    ratio = slowest.quantile(0.5) / alone.quantile(0.5)
    note = f"{slowest.quantile(0.5):.0f} us, alone {alone.quantile(0.5):.0f} us"
    return [
        shown(f"{title}, p50 of the slowest to that of one alone", ratio, "times", COMMAND, note),
        shown(
            f"{title}, samples without a command, most of any",
            100 * max(segment.lost for segment in beside),
            "%",
            COMMAND,
            f"alone {alone.lost:.2%}",
        ),
    ]


def _against(title: str, name: str, share: float, chain: Segment, relay: Segment) -> Row:
    """The chain's quantile in units of the bare relay's."""
    mine, floor = chain.quantile(share), relay.quantile(share)
    claim = f"{title}, {name} to the bare relay's"
    return _ratio(claim, mine, floor, LIMIT, f"{mine:.0f} us, relay {floor:.0f} us")


def _ratio(claim: str, mine: float, other: float, limit: float, note: str) -> Row:
    if math.inf in (mine, other):
        measured = "none: more samples went unanswered than the quantile leaves out"
        return Row(claim, measured, f"≤ {limit:g} times", False, COMMAND)
    return at_most(claim, mine / other, limit, "", COMMAND, note)


def _sustained(rate: float, seconds: float) -> Row:
    segment = segments.chain(rate, seconds)
    late = max(segment.overruns.values()) / len(segment.latencies)
    note = ", ".join(f"{name} {count}" for name, count in segment.overruns.items())
    note += f" of {len(segment.latencies)} steps"
    claim = f"{rate:.0f} Hz for {seconds:.0f} s, late steps"
    return at_most(claim, 100 * late, 100 * OVERRUN_SHARE, "%", COMMAND, note)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer samples: a look, not a measurement")
    parser.add_argument("--against", metavar="REV", help="the chain alone, in turns with another revision's")
    options = parser.parse_args()
    if options.against:
        against.show(against.compare(options.against, _CHAIN))
    else:
        show(rows(options.quick))


if __name__ == "__main__":
    main()
