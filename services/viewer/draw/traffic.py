"""How the topics arrive: how often, in percent of what the table of topics says, and how much later than at best."""

from __future__ import annotations

import math
from collections.abc import Mapping

import rerun as rr

from services.viewer.draw.curves import lines
from shared.topics import TOPICS
from shared.wire.subscription import Subscription

RATE, DELAY = "traffic/rate", "traffic/delay"
PERIODIC = tuple(topic for topic in TOPICS if topic.rate > 0.0)
"""Topics that come at a rate."""
_COLOURS = tuple((60 + 37 * i % 180, 60 + 101 * i % 180, 60 + 167 * i % 180) for i in range(len(PERIODIC)))


def style(rec: rr.RecordingStream) -> None:
    """Names and colours, once."""
    for path in (RATE, DELAY):
        lines(rec, path, [topic.key for topic in PERIODIC], _COLOURS)


def draw(rec: rr.RecordingStream, subscriptions: Mapping[str, Subscription], now_ns: int) -> None:
    """Add a point to each curve; a topic that was never heard has none."""
    heard = [subscriptions[topic.key] for topic in PERIODIC]
    rates = [100.0 * one.rate(now_ns) / one.topic.rate if one.latest else math.nan for one in heard]
    rec.log(RATE, rr.Scalars(rates))
    rec.log(DELAY, rr.Scalars([1e3 * one.latest.delay if one.latest else math.nan for one in heard]))
