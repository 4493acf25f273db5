"""What is written and drawn on the pictures of the carry's film: captions, arrows, and the wrench with its limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from services.sim.film.floor import TRACE
from shared.spatial import Array

INK, GREY, PALE = (40, 44, 52), (110, 116, 126), (214, 217, 222)
CALM, NEAR_LIMIT, OVER = (46, 125, 90), (214, 148, 30), (200, 60, 45)
ON_ROBOT, OF_PERSON = (205, 70, 40), (25, 95, 175)
"""Colours of the two forces."""
_LEAST = 1.5
"""Force [N] below which an arrow says nothing."""
_AXES = ("force x", "force y", "force z", "torque x", "torque y", "torque z")
_FULL = 1.3
"""What the display's half width stands for, in limits."""
_NEAR = 0.8


@dataclass(frozen=True)
class Arrow:
    """A force as it appears in a picture.

    Attributes:
        root: where it acts (2,) [px].
        tip: where it points (2,) [px].
        size: [N].
    """

    root: Array
    tip: Array
    size: float


class Gauges:
    """Draws on pictures of the film's size."""

    def __init__(self) -> None:
        self._fonts = {size: ImageFont.load_default(size) for size in (13, 16, 24)}

    def arrow(self, picture: Image.Image, arrow: Arrow, colour: tuple[int, int, int]) -> None:
        """A force with its size."""
        if arrow.size < _LEAST:
            return
        pen = ImageDraw.Draw(picture)
        way = arrow.tip - arrow.root
        length = float(np.linalg.norm(way))
        if length < 1.0:
            return
        along = way / length
        aside = np.array((-along[1], along[0]))
        head = min(14.0, 0.6 * length)
        neck = arrow.tip - head * along
        for width, colour_of in ((9, (255, 255, 255)), (5, colour)):
            pen.line((*arrow.root, *neck), fill=colour_of, width=width)
        wings = [tuple(neck + side * 0.55 * head * aside) for side in (1.0, -1.0)]
        pen.polygon([tuple(arrow.tip), *wings], fill=colour)
        place = arrow.tip + 15.0 * along
        pen.text(
            (float(place[0]), float(place[1])),
            f"{arrow.size:.0f} N",
            colour,
            self._fonts[16],
            anchor="mm",
            stroke_width=2,
            stroke_fill=(255, 255, 255),
        )

    def title(self, picture: Image.Image, caption: str, below: str) -> None:
        """What happens, and in smaller print what else is to be known."""
        pen = ImageDraw.Draw(picture)
        pen.text((22, 16), caption, INK, self._fonts[24])
        pen.text((22, 50), below, GREY, self._fonts[16])

    def key(self, picture: Image.Image) -> None:
        """What is drawn into the scene."""
        pen = ImageDraw.Draw(picture)
        row = picture.height - 66
        for colour, words in (
            (ON_ROBOT, "force of the panel on the gripper"),
            (OF_PERSON, "force of the person's hands"),
        ):
            pen.rectangle((22, row + 3, 40, row + 9), fill=colour)
            pen.text((48, row + 6), words, INK, self._fonts[13], anchor="lm")
            row += 20
        pen.ellipse((22, row, 40, row + 11), outline=TRACE, width=2)
        pen.text((48, row + 6), "where the robot stood at the beginning", INK, self._fonts[13], anchor="lm")

    def wrench(self, picture: Image.Image, wrench: Array, limit: Array) -> None:
        """Six bars (6,) [N, Nm] between their limits (6,), in the lower right corner."""
        width, height = 296, 152
        left, top = picture.width - width - 16, picture.height - height - 14
        pen = ImageDraw.Draw(picture, "RGBA")
        pen.rounded_rectangle((left, top, left + width, top + height), 6, fill=(255, 255, 255, 225), outline=PALE)
        pen.text((left + 12, top + 8), "wrench on the gripper less the agreed weight", GREY, self._fonts[13])
        middle, half = left + 146, 76
        mark = half / _FULL
        for index, name in enumerate(_AXES):
            row = top + 38 + 19 * index
            pen.text((left + 12, row), name, INK, self._fonts[13], anchor="lm")
            pen.rectangle((middle - half, row - 5, middle + half, row + 5), fill=(236, 238, 241))
            share = float(wrench[index] / limit[index])
            end = middle + mark * float(np.clip(share, -_FULL, _FULL))
            colour = OVER if abs(share) > 1.0 else NEAR_LIMIT if abs(share) > _NEAR else CALM
            pen.rectangle((min(middle, end), row - 5, max(middle, end), row + 5), fill=colour)
            unit = "N" if index < 3 else "Nm"
            pen.text((middle + half + 6, row), f"±{limit[index]:g} {unit}", GREY, self._fonts[13], anchor="lm")
        for column, fill in ((middle - mark, INK), (middle + mark, INK), (middle, GREY)):
            pen.line((column, top + 30, column, top + height - 11), fill=fill, width=1)

    def inset(self, picture: Image.Image, view: Image.Image, words: str) -> None:
        """A small picture with its name in the upper right corner."""
        left, top = picture.width - view.width - 18, 18
        pen = ImageDraw.Draw(picture)
        pen.rectangle((left - 2, top - 2, left + view.width + 1, top + view.height + 1), fill=INK)
        picture.paste(view, (left, top))
        pen.text((left, top + view.height + 6), words, GREY, self._fonts[13])
