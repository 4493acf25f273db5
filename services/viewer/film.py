"""Films and stills of recordings, taken from the view: what a film shows is drawn as everywhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import rerun as rr
from PIL import Image, ImageDraw, ImageFont

from services.viewer.blueprint import FILM_ROWS, filmed
from services.viewer.draw.drawing import Drawing
from services.viewer.heard import Ears
from services.viewer.recorded import RecordedClock
from services.viewer.sentence import Sentence
from services.viewer.stream import Stream
from services.viewer.take import Take
from services.viewer.windowless import Picture, Windowless
from shared.clock import nanoseconds, seconds
from shared.topics import SENSOR_CAMERA
from shared.wire.log import Log

FILM, STRIP = "scene.mp4", "strip.png"
"""Names of the film, and of the stills that it gets beside it."""
WORDS = "film/words"
ALONE, BESIDE = (960, 540), (640, 540)
"""Sizes of a picture of a film by itself, and of one of two [px]."""
MEMORY = "2GB"
"""What a drawing may take until its viewer has got it, ten times what that of a carry does."""
HELD = 0.5
"""Time [s] of film for which a sentence stands, so that it can be read; one of another kind stands at once."""
STILL, COLUMNS = (400, 300), 4
"""Size of a still [px], and how many there are side by side."""
_MARGIN, _GAP, _NAME = 16, 8, 34  # [px]
_INK, _GREY, _PAPER = (40, 44, 52), (110, 116, 126), (255, 255, 255)


def render(takes: Sequence[Take], folder: Path, rate: float = 15.0, speed: float = 3.0) -> int:
    """Write the film of recordings, side by side, and the strip of stills of the last one to a folder.

    Args:
        takes: from left to right; of the shorter ones the last picture stays.
        folder: where film and strip go.
        rate: pictures per second of film.
        speed: how many times faster than it happened.

    Returns:
        The number of pictures.

    Raises:
        Misconfigured: there is no viewer to take them; one line.
        NoRecording, OSError: a recording cannot be read.
    """
    with ExitStack() as stack:
        shots = [stack.enter_context(Shot(take, ALONE if len(takes) == 1 else BESIDE, rate, speed)) for take in takes]
        stills = [part for part in takes[-1].parts if part.still]
        if stills:
            pictures = [(part.still, part.end, shots[-1].picture(part.end)) for part in stills]
            imageio.imwrite(folder / STRIP, strip(pictures))
        times = np.arange(round(max(shot.end for shot in shots) * rate / speed) + 1) * speed / rate
        # A viewer that ends early leaves no half film that looks like a whole one.
        half = folder / f"unfinished-{FILM}"
        stack.callback(half.unlink, missing_ok=True)
        writer: Any = imageio.get_writer(half, fps=rate, codec="libx264", quality=7, macro_block_size=4)
        with closing(writer) as film:  # which does not close itself after an error
            for time in times:
                film.append_data(np.hstack([shot.picture(time) for shot in shots]))
        half.replace(folder / FILM)
        return len(times)


class Shot:
    """The pictures of one take; a context manager that ends its viewer.

    Attributes:
        end: when its last picture was taken [s].

    Args:
        take: what is filmed.
        size: of the pictures [px].
        rate, speed: of the film: it is drawn for no more pictures than there are.
    """

    def __init__(self, take: Take, size: tuple[int, int], rate: float, speed: float) -> None:
        self._open = ExitStack()
        with ExitStack() as opened:
            stream = opened.enter_context(Stream.served("127.0.0.1", 0, MEMORY))
            self._step, self.end, camera = speed / rate, 0.0, False
            for self.end, ears in _drawn(stream.rec, take, rate, speed):
                camera = camera or ears.newest(SENSOR_CAMERA.key) is not None
            stream.rec.send_blueprint(filmed(WORDS, camera))
            stream.rec.flush()
            # What comes last is there when all is.
            stream.rec.set_time("time", duration=self.end + 1.0)
            stream.rec.log(WORDS, rr.Clear(recursive=False))
            stream.rec.flush()
            self._viewer = opened.enter_context(Windowless(stream.uri, size, self.end + 1.0))
            self._open = opened.pop_all()
        self._shown: tuple[int, Picture] | None = None

    def picture(self, time: float) -> Picture:
        """That of a time [s], which is the nearest one that was drawn; see ``Windowless.picture``."""
        index = round(min(max(time, 0.0), self.end) / self._step)
        if self._shown is None or self._shown[0] != index:
            self._shown = index, self._viewer.picture(index * self._step)
        return self._shown[1]

    def __enter__(self) -> Shot:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()


def _drawn(rec: rr.RecordingStream, take: Take, rate: float, speed: float) -> Iterator[tuple[float, Ears]]:
    """Draw what each picture shows; gives the time [s] of each."""
    zero = nanoseconds(take.zero)
    clock = RecordedClock()
    clock.now = -zero
    ears = Ears(clock, 0)
    drawing = Drawing(rec, ears)
    fast = "" if speed == 1.0 else f", {speed:g} x as fast"
    said, since, due, count = Sentence("", drawing.sentence.kind), -np.inf, 0, 0
    for key, arrival_ns, payload in Log(take.path):
        while (now := arrival_ns - zero) > due:
            clock.now = max(clock.now, due)
            drawing.advance()
            time, sentence = seconds(due), drawing.sentence
            if sentence.kind is not said.kind or time - since >= HELD * speed:
                said, since = sentence, time
            part = next((one for one in reversed(take.parts) if one.start <= time < one.end), None)
            head = " · ".join(filter(None, (take.title, part.caption if part else "", f"{time:.0f} s{fast}")))
            rec.set_time("time", duration=time)
            rec.log(WORDS, rr.TextDocument(f"{head}\n### {said.text}", media_type=rr.MediaType.MARKDOWN))
            yield time, ears
            count += 1
            due = round(nanoseconds(count * speed) / rate)
        clock.now = max(clock.now, now)
        ears.hear(key, payload)


def strip(stills: Sequence[tuple[str, float, Picture]]) -> Picture:
    """Stills with their names and times [s], in rows."""
    width, height = STILL
    rows = -(-len(stills) // COLUMNS)
    step, line = width + _GAP, height + _NAME + _GAP
    size = (2 * _MARGIN + min(len(stills), COLUMNS) * step - _GAP, 2 * _MARGIN + rows * line - _GAP)
    whole = Image.new("RGB", size, _PAPER)
    pen, font, small = ImageDraw.Draw(whole), ImageFont.load_default(23), ImageFont.load_default(17)
    for index, (name, time, picture) in enumerate(stills):
        left, top = _MARGIN + index % COLUMNS * step, _MARGIN + index // COLUMNS * line
        pen.text((left, top), f"{chr(ord('a') + index)}) {name}", _INK, font)
        pen.text((left + width, top + 3), f"{time:.0f} s", _GREY, small, anchor="ra")
        whole.paste(_cut(Image.fromarray(picture)), (left, top + _NAME))
    return np.asarray(whole)


def _cut(picture: Image.Image) -> Image.Image:
    """The scene of a picture, in a still's format."""
    top, bottom = (sum(FILM_ROWS[:row]) / sum(FILM_ROWS) * picture.height for row in (1, 2))
    half = (bottom - top) * STILL[0] / STILL[1] / 2.0
    middle = picture.width / 2.0
    return picture.resize(STILL, Image.Resampling.LANCZOS, (middle - half, top, middle + half, bottom))
