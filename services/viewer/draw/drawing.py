"""What is drawn when: the newest of the scene often, all of the curves and the traffic now and then, states on change.

The same for a live robot and a recording: whoever feeds the ears calls ``advance`` as their time goes on.
"""

from __future__ import annotations

import math
import re

import rerun as rr

from services.viewer.draw import show, traffic
from services.viewer.draw.robot import REPEAT, Robot
from services.viewer.draw.states import state
from services.viewer.draw.why import draw_sentence, note_sentence
from services.viewer.heard import Ears
from services.viewer.sample import Newest, Sample
from services.viewer.sentence import Sentence, say

PERIOD = 0.1
"""Time [s] between two pictures of the scene: more the eye does not need, and each costs."""
_NUMBER = re.compile(r"[\d.]+")
"""Of a sentence that says the same as before but for its numbers no note is taken."""
CURVES_EVERY, SENTENCE_EVERY, TRAFFIC_EVERY = 0.2, 0.25, 1.0  # [s]


class Drawing:
    """Draws what ears hear.

    Attributes:
        sentence: that is shown at present.

    Args:
        rec: to draw into.
        ears: live or of a recording.
        curves_every: time [s] between two pieces of a curve; short ones cost whoever draws and whoever looks.
        side: path below which the stream draws; empty for all of it.
    """

    def __init__(self, rec: rr.RecordingStream, ears: Ears, curves_every: float = CURVES_EVERY, side: str = "") -> None:
        self._rec, self._ears = rec, ears
        self._rows = show.table(Robot(rec, side))
        show.style(rec)
        traffic.style(rec)
        self._newest = Newest(ears.newest)
        self._waiting: dict[str, list[Sample]] = {key: [] for key in self._rows}
        self._silent: set[str] = set()
        self._states: dict[str, tuple[str, float]] = {}
        self._curves_every = curves_every
        self._done: dict[str, float] = {}
        self.sentence = say({})
        self._said_at, self._noted = -math.inf, ""

    def advance(self, cut_off: str = "") -> None:
        """Draw what is due.

        Args:
            cut_off: why nothing can be heard; empty if that is not so.
        """
        now = self._ears.now
        # Of this thread, until it is set again.
        self._rec.set_time("time", duration=now)
        for key, row in self._rows.items():
            arrived = self._ears.take(key)
            if arrived:
                self._silent.discard(key)
                message = arrived[-1].message
                if row.draw:
                    row.draw(self._rec, Sample(now, message), self._newest)
                for path, word in row.states(message).items():
                    self._state(path, word, now)
                if row.plot:
                    self._waiting[key] += arrived
            else:
                self._fall_silent(key, now)
        if self._is_due("curves", self._curves_every, now):
            self._plot()
        if self._is_due("traffic", TRAFFIC_EVERY, now):
            traffic.draw(self._rec, self._ears.subscriptions, self._ears.now_ns)
        if self._is_due("sentence", SENTENCE_EVERY, now):
            self._say(now, say(self._ears.known(), cut_off))

    def end(self) -> None:
        """Draw what is left."""
        self.advance()
        self._plot()

    def _is_due(self, what: str, period: float, now: float) -> bool:
        due = now - self._done.get(what, -math.inf) >= period
        if due:
            self._done[what] = now
        return due

    def _plot(self) -> None:
        for key, samples in self._waiting.items():
            plot = self._rows[key].plot
            if samples and plot:
                plot(self._rec, samples)
                samples.clear()

    def _fall_silent(self, key: str, now: float) -> None:
        """Take away what is too old to be looked at as if it were so."""
        one = self._ears.subscriptions[key]
        if key in self._silent or one.latest is None or one.age(self._ears.now_ns) <= one.age_limit:
            return
        self._silent.add(key)
        for path in self._rows[key].entities:
            self._rec.log(path, rr.Clear(recursive=True))
        for path in self._rows[key].states(one.latest.message):
            self._state(path, "silent", now)

    def _state(self, path: str, word: str, now: float) -> None:
        before, since = self._states.get(path, ("", -math.inf))
        if word != before or now - since >= REPEAT:
            self._states[path] = word, now
            state(self._rec, path, word)

    def _say(self, now: float, sentence: Sentence) -> None:
        if _NUMBER.sub("", sentence.text) != self._noted:
            self._noted = _NUMBER.sub("", sentence.text)
            note_sentence(self._rec, sentence)
        if sentence != self.sentence or now - self._said_at >= REPEAT:
            self.sentence, self._said_at = sentence, now
            draw_sentence(self._rec, sentence)
