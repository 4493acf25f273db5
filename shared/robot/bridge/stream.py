"""Watch over one topic of the robot: whether it comes as often as it should, from one publisher, and its stamps."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any

from shared.clock import in_words, seconds
from shared.robot.far_side import Heard

MISSING_AFTER = 3.0
"""[s] of silence after which a topic counts as missing."""
WINDOW = 2.0
"""[s] over which rates are counted."""
SLOW = 0.8
"""Share [1] of the profile's rate below which a topic is too slow."""
CLOCK_OFF = 2.0
"""[s] between the robot's clock and this machine's that are told of."""
JUMP = 0.5
"""[s] by which a stamp goes faster or slower than arrivals when it jumps."""
REMEMBERED = 10.0
"""[s] for which what was seen once is told of."""
_STANDING = 10  # messages with one and the same stamp


class StreamWatch:
    """What is wrong with a topic.

    Attributes:
        owner: the publisher that is listened to: the first one, until it has been silent for ``MISSING_AFTER``.

    Args:
        topic: its name.
        rate: that the profile says [Hz]; 0 if it does not matter.
    """

    def __init__(self, topic: str, rate: float) -> None:
        self.topic = topic
        self.owner = ""
        self._rate = rate
        self._started: float | None = None
        self._number = 0
        self._last_heard = 0.0
        self._owner_heard = 0.0
        self._counted: deque[tuple[float, int]] = deque()
        self._stamp: int | None = None
        self._arrival = 0
        self._same = 0
        self._seen: dict[str, float] = {}
        self._now = 0.0
        self._ahead = 0.0

    def hear(self, heard: Heard[Any] | None, now: int, wall: int) -> bool:
        """Look at the newest message; whether it is new, and from the publisher that is listened to.

        Args:
            heard: as the far side has it.
            now: [ns] of the steady clock of its arrivals.
            wall: [ns] of this machine's wall clock, which stamps are compared with.
        """
        self._now = seconds(now)
        if self._started is None:
            self._started = self._last_heard = self._now
        if heard is None or heard.number == self._number:
            return False
        if heard.number < self._number:
            self._counted.clear()
        self._number = heard.number
        self._last_heard = self._now
        self._counted.append((seconds(heard.arrival), heard.number))
        while self._now - self._counted[0][0] > WINDOW:
            self._counted.popleft()
        if not self._is_owner(heard.sender):
            self._note(f"{self.topic} has two publishers, {self.owner} and {heard.sender}: only the first is heard")
            return False
        self._owner_heard = self._now
        self._judge_stamp(heard, now, wall)
        return True

    def lines(self) -> Iterator[str]:
        """What is wrong now, one line each."""
        silent = self._now - self._last_heard
        if silent > MISSING_AFTER:
            which = "nothing has arrived" if self._number == 0 else f"silent for {in_words(silent)}"
            yield f"{self.topic}: {which}. Is that its name, and is the robot running?"
            return
        if self._rate and len(self._counted) > 1:
            (since, first), (until, last) = self._counted[0], self._counted[-1]
            if until - since > 0.5 * WINDOW and (rate := (last - first) / (until - since)) < SLOW * self._rate:
                yield f"{self.topic} comes at {rate:.0f} Hz, the profile says {self._rate:g} Hz"
        if self._same >= _STANDING:
            yield f"{self.topic}: its stamp stands still. Is it published anew, or the same message again and again?"
        if abs(self._ahead) > CLOCK_OFF:
            way = "ahead of" if self._ahead > 0.0 else "behind"
            yield (
                f"{self.topic}: the robot's clock is {in_words(abs(self._ahead))} {way} this machine's. Set both "
                "by NTP, else the robot may refuse commands by their stamp"
            )
        yield from (line for line, when in self._seen.items() if self._now - when < REMEMBERED)

    def _is_owner(self, sender: str) -> bool:
        if not self.owner or self._now - self._owner_heard > MISSING_AFTER:
            self.owner = sender
        return sender == self.owner or not sender

    def _judge_stamp(self, heard: Heard[Any], now: int, wall: int) -> None:
        if heard.stamp is None:
            return
        before, arrival_before = self._stamp, self._arrival
        self._stamp, self._arrival = heard.stamp, heard.arrival
        self._same = self._same + 1 if heard.stamp == before else 0
        self._ahead = seconds(heard.stamp - (wall - (now - heard.arrival)))
        if before is not None and self._same == 0:
            jump = seconds((heard.stamp - before) - (heard.arrival - arrival_before))
            if abs(jump) > JUMP:
                self._note(f"{self.topic}: its stamp has jumped by {jump:+.1f} s. Was the robot's clock set?")

    def _note(self, line: str) -> None:
        self._seen = {known: when for known, when in self._seen.items() if self._now - when < REMEMBERED}
        self._seen[line] = self._now
