"""The film of a carry, and a strip of stills of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from services.sim.camera.canvas import Picture
from services.sim.camera.renderer import Renderer
from services.sim.film.carry_recording import CarryRun, Moment
from services.sim.film.carry_scene import CarryScene
from services.sim.film.gauges import GREY, INK, OF_PERSON, ON_ROBOT, Arrow, Gauges
from shared.spatial import Array

WIDTH, HEIGHT = 960, 540
OVERSAMPLING = 4.0 / 3.0
"""The renderer draws hard edges; a larger picture made smaller has soft ones."""
PER_NEWTON = 0.035
"""Length of a force's arrow in the scene [m/N]."""
INSET = (256, 192)
"""Size of the head camera's picture in the film [px]."""
STILL = (400, 300)
"""Size of a picture of the strip [px]."""
CUT = (72.0, 40.0, 616.0)
"""Left, upper edge and width [px] of what a picture of the strip shows of one of the film."""
_MARGIN, _GAP, _WORDS = 16, 8, 34


def frames(run: CarryRun, rate: float, speed: float) -> Iterator[Picture]:
    """Pictures (HEIGHT, WIDTH, 3) of a run at ``rate`` [1/s of film], ``speed`` times as fast as it happened."""
    studio = _Studio(run)
    gauges = Gauges()
    fast = "" if speed == 1.0 else f"   {speed:g} x as fast"
    try:
        for time in np.arange(run.time[0], run.time[-1], speed / rate):
            moment = run.at(time)
            picture = studio.scene(moment, gauges)
            gauges.title(picture, moment.caption, f"{moment.time:.1f} s{fast}")
            gauges.key(picture)
            if np.isfinite(moment.limit).all():
                gauges.wrench(picture, moment.wrench, moment.limit)
            if moment.looking:
                view = studio.head(moment).resize(INSET, Image.Resampling.BILINEAR)
                gauges.inset(picture, view, "what the head camera sees")
            yield np.asarray(picture)
    finally:
        studio.close()


def strip(run: CarryRun) -> Picture:
    """The run's moments side by side: above the scene, below what the head camera sees."""
    width, height = STILL
    columns = len(run.moments)
    whole = Image.new(
        "RGB",
        (2 * _MARGIN + columns * (width + _GAP) - _GAP, 2 * _MARGIN + 2 * height + _GAP + _WORDS),
        (255, 255, 255),
    )
    pen, font, small = ImageDraw.Draw(whole), ImageFont.load_default(23), ImageFont.load_default(17)
    studio = _Studio(run)
    gauges = Gauges()
    try:
        for index, (time, caption) in enumerate(run.moments):
            moment = run.at(time)
            left = _MARGIN + index * (width + _GAP)
            pen.text((left, _MARGIN), f"{chr(ord('a') + index)}) {caption}", INK, font)
            pen.text((left + width, _MARGIN + 3), f"{moment.time:.0f} s", GREY, small, anchor="ra")
            top = _MARGIN + _WORDS
            whole.paste(_cut(studio.scene(moment, gauges)), (left, top))
            seen = studio.head(moment).resize(STILL, Image.Resampling.LANCZOS)
            whole.paste(seen, (left, top + height + _GAP))
            if index == 0:
                pen.text((left + 8, top + 2 * height - 20), "head camera", INK, small)
    finally:
        studio.close()
    return np.asarray(whole)


def _cut(picture: Image.Image) -> Image.Image:
    """The part of a picture of the film where things happen, in the strip's format."""
    left, top, width = CUT
    return picture.resize(STILL, Image.Resampling.LANCZOS, (left, top, left + width, top + width * STILL[1] / STILL[0]))


class _Studio:
    """Both cameras.

    Args:
        run: what they look at.
    """

    def __init__(self, run: CarryRun) -> None:
        self._run = run
        self._scene = CarryScene(run.scenery, (round(WIDTH * OVERSAMPLING), round(HEIGHT * OVERSAMPLING)))
        self._renderer = Renderer(run.scenery)

    def scene(self, moment: Moment, gauges: Gauges) -> Image.Image:
        """The room with the forces in it."""
        shown = Image.fromarray(self._scene.picture(moment))
        picture = shown.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
        gauges.arrow(picture, self._arrow(self._scene.tool(), moment.force), ON_ROBOT)
        gauges.arrow(picture, self._arrow(moment.hands, moment.hands_force), OF_PERSON)
        return picture

    def _arrow(self, place: tuple[float, ...] | Array, force: Array) -> Arrow:
        root = np.asarray(place)
        ends = [self._scene.pixel(point) / OVERSAMPLING for point in (root, root + PER_NEWTON * force)]
        return Arrow(ends[0], ends[1], float(np.linalg.norm(force)))

    def head(self, moment: Moment) -> Image.Image:
        """What the head camera sees."""
        return Image.fromarray(self._renderer.picture(self._run.view(moment)))

    def close(self) -> None:
        """Release both."""
        self._scene.close()
        self._renderer.close()
