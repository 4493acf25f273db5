"""Why nothing is heard: silence has several causes, and each has a remedy of its own."""

from __future__ import annotations

from dataclasses import replace

from shared.faults import Fault, FaultKind
from shared.processes import publisher_named
from shared.topics import Topic
from shared.wire.bus import Bus


def explained(fault: Fault, topic: Topic, bus: Bus) -> Fault:
    """The fault, with the cause in its remedy if it is silence of a topic and the cause is known."""
    if fault.kind not in (FaultKind.NEVER_SEEN, FaultKind.SILENT):
        return fault
    if not bus.connected():
        return replace(fault, remedy="There is no connection to the router. Is it running?")
    alive = sorted({name for name in bus.present().values() if publisher_named(name) in topic.publishers})
    if alive:
        return replace(fault, remedy=f"{' and '.join(alive)} is alive, but nothing of it arrives here")
    return fault
