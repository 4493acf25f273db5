"""The sentence on top of everything."""

from __future__ import annotations

import rerun as rr

from services.viewer.sentence import Kind, Sentence

NOW, HISTORY = "why/now", "why/history"
_LEVELS = {
    Kind.LOST: rr.TextLogLevel.ERROR,
    Kind.STOPPED: rr.TextLogLevel.ERROR,
    Kind.HELD: rr.TextLogLevel.WARN,
    Kind.WAITING: rr.TextLogLevel.WARN,
    Kind.FREE: rr.TextLogLevel.INFO,
}


def draw_sentence(rec: rr.RecordingStream, sentence: Sentence) -> None:
    """Show the sentence, and below it what else is to be known."""
    more = "\n\n" + " · ".join(sentence.more)
    rec.log(NOW, rr.TextDocument(f"# {sentence.text}{more}", media_type=rr.MediaType.MARKDOWN))


def note_sentence(rec: rr.RecordingStream, sentence: Sentence) -> None:
    """Add the sentence to what was said before."""
    rec.log(HISTORY, rr.TextLog(sentence.text, level=_LEVELS[sentence.kind]))


def note(rec: rr.RecordingStream, text: str, time: float) -> None:
    """Add words of one's own, at a time [s]."""
    rec.set_time("time", duration=time)
    rec.log(HISTORY, rr.TextLog(text, level=rr.TextLogLevel.INFO))
