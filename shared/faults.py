"""Faults of a service's inputs and of its loop: a row each, with its name and its sentence for the human."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class FaultKind(Enum):
    """Kinds in the order in which they are reported: the more fundamental first."""

    NEVER_SEEN = "never_seen"
    SILENT = "silent"
    REFUSED = "refused"
    LOSSY = "lossy"
    DELAYED = "delayed"
    INVALID = "invalid"
    INTERNAL = "internal"
    OVERRUN = "overrun"
    ARMING = "arming"
    SHUTDOWN = "shutdown"


_LONGEST_WORD = 40
"""Characters kept of another publisher's word: texts travel on, and must not outgrow a message."""

_SEVERITY = {kind: order for order, kind in enumerate(FaultKind)}


@dataclass(frozen=True)
class Fault:
    """One present fault.

    Attributes:
        kind: which row.
        key: the topic concerned, empty if none.
        what: one sentence: what, where, the limit.
        word: for ``INVALID``, the publisher's own word for it (such as "stuck"), empty if it gave none.
        remedy: a second sentence: what to do about it, or where to look; empty if the first one says it.
    """

    kind: FaultKind
    key: str
    what: str
    word: str = ""
    remedy: str = ""

    @property
    def text(self) -> str:
        """All of it, for the human."""
        return f"{self.what}. {self.remedy}" if self.remedy else self.what

    @property
    def waiting(self) -> bool:
        """The service has not begun to work yet; nothing has broken."""
        return self.kind in (FaultKind.NEVER_SEEN, FaultKind.ARMING)

    @property
    def severity(self) -> int:
        """Lower is more fundamental."""
        return _SEVERITY[self.kind]

    def __str__(self) -> str:
        return self.text


def never_seen(key: str, publisher: str) -> Fault:
    """No valid message has arrived since the start."""
    what = f"waiting for {key}: never received"
    return Fault(FaultKind.NEVER_SEEN, key, what, remedy=f"Is {publisher} running?")


def silent(key: str, publisher: str, age: float, limit: float) -> Fault:
    """The last message is too old."""
    what = f"{key} is {age * 1e3:.0f} ms old, allowed are {limit * 1e3:.0f} ms"
    return Fault(FaultKind.SILENT, key, what, remedy=f"Is {publisher} running?")


def refused(key: str, count: int, reason: str) -> Fault:
    """Everything that arrives is rejected."""
    return Fault(FaultKind.REFUSED, key, f"{key}: {count} messages rejected, the last one: {reason}")


def lossy(key: str, share: float, limit: float) -> Fault:
    """Too many messages are lost on the way."""
    return Fault(
        FaultKind.LOSSY,
        key,
        f"{key}: {share:.0%} of the messages of the last second were lost, allowed are {limit:.0%}: check the network",
    )


def delayed(key: str, delay: float, limit: float) -> Fault:
    """Messages take longer than the declared delay."""
    return Fault(
        FaultKind.DELAYED,
        key,
        f"{key} arrives {delay * 1e3:.0f} ms later than it did at its fastest, declared are {limit * 1e3:.0f} ms: "
        "mend the network or the load, or declare a longer delay",
    )


def invalid(key: str, word: str) -> Fault:
    """The publisher itself says that its message is not to be trusted."""
    word = word[:_LONGEST_WORD]
    text = f"{key} is marked invalid by its publisher ({word or 'no reason given'})"
    return Fault(FaultKind.INVALID, key, text, word)


def overrun(late: int, steps: int, limit: float) -> Fault:
    """Too many steps of the last second were late."""
    text = f"{late} of the last {steps} steps were late, allowed are {limit:.0%}: lower the rate or the machine's load"
    return Fault(FaultKind.OVERRUN, "", text)


def stalled(late: float, limit: float) -> Fault:
    """One step came much too late."""
    text = f"the loop stalled for {late * 1e3:.0f} ms, allowed are {limit * 1e3:.0f} ms: lower the machine's load"
    return Fault(FaultKind.OVERRUN, "", text)


def arming(left: float) -> Fault:
    """All inputs are healthy, but not for long enough."""
    return Fault(FaultKind.ARMING, "", f"inputs are healthy, starting in {left:.1f} s")


SHUTDOWN = Fault(FaultKind.SHUTDOWN, "", "shutting down")


def internal(problem: Exception) -> Fault:
    """A step failed; its outputs were discarded."""
    text = f"a step failed and was replaced by braking ({type(problem).__name__}: {problem})"
    return Fault(FaultKind.INTERNAL, "", text)
