"""Films: as long as what was recorded, side by side, with the stills of the parts that have one."""

from __future__ import annotations

from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from services.viewer import film
from services.viewer.film import ALONE, BESIDE, FILM, STRIP, render
from services.viewer.take import Part, Take
from shared import topics as t
from shared.clock import nanoseconds
from shared.loop.config import Misconfigured
from shared.messages import BaseState, Header
from shared.wire.codec import encode
from shared.wire.log import Heard, write_log
from tests.services.viewer.messages import MESSAGES
from tests.support import vulkan

pytestmark = [pytest.mark.processes, pytest.mark.slow, pytest.mark.timeout(400)]

BEGIN = 50.0
"""What the recorder's clock shows [s] at the beginning."""
PARTS = (Part("lift", 0.5, 1.0, "both lift the panel", "lifted"), Part("rest", 1.0, 2.0, "it rests"))


def take(path: Path, duration: float) -> Take:
    """A robot that drives on for a time [s]; the view follows it."""
    heard = []
    for number in range(round(30 * duration)):
        now = nanoseconds(BEGIN + number / 30)
        messages = {**MESSAGES, t.STATE_BASE: BaseState((0.02 * number, 0.0), 0.0, (0.0, 0.0, 0.0))}
        heard += [
            Heard(topic.key, now, encode(message, Header(number, 1, now, True)))
            for topic, message in messages.items()
            if topic is not t.SENSOR_CAMERA
        ]
    write_log(path, {}, heard)
    return Take(path, "certified", BEGIN, PARTS)


@pytest.fixture(autouse=True)
def drawn() -> None:
    vulkan.wanted()


def test_a_film_has_its_length_and_its_pictures_change(tmp_path: Path) -> None:
    assert render([take(tmp_path / "one.mcap", 2.0)], tmp_path, rate=5.0, speed=2.0) == 5
    shown = [np.asarray(picture, dtype=float) for picture in imageio.get_reader(tmp_path / FILM)]
    assert [picture.shape for picture in shown] == [(ALONE[1], ALONE[0], 3)] * 5
    scene = slice(round(0.2 * ALONE[1]), round(0.7 * ALONE[1]))
    assert np.abs(shown[0][scene] - shown[-1][scene]).mean() > 0.5
    # One still, below its name on white paper.
    strip = imageio.imread(tmp_path / STRIP)
    below = (strip[-film.STILL[1] :] != 255).any(axis=(0, 2))
    assert below.sum() == film.STILL[0]


def test_two_are_side_by_side_and_the_shorter_one_stays(tmp_path: Path) -> None:
    takes = [take(tmp_path / "short.mcap", 1.0), take(tmp_path / "long.mcap", 2.0)]
    assert render(takes, tmp_path, rate=2.0, speed=1.0) == 4
    shown = [np.asarray(picture, dtype=float) for picture in imageio.get_reader(tmp_path / FILM)]
    assert shown[0].shape == (BESIDE[1], 2 * BESIDE[0], 3)
    scene = slice(round(0.2 * BESIDE[1]), round(0.7 * BESIDE[1]))
    change = np.abs(shown[-1][scene] - shown[-2][scene])
    assert change[:, : BESIDE[0]].mean() < 0.1 < change[:, BESIDE[0] :].mean()


class Ending:
    """Gives one picture, and no other one."""

    end = 1.0

    def __init__(self, *given: object) -> None: ...

    def __enter__(self) -> Ending:
        return self

    def __exit__(self, *_: object) -> None: ...

    def picture(self, time: float) -> np.ndarray:
        if time > 0.0:
            raise Misconfigured("rerun's viewer does not answer")
        return np.zeros((ALONE[1], ALONE[0], 3), np.uint8)


def test_a_viewer_that_ends_early_leaves_no_half_film(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film, "Shot", Ending)
    with pytest.raises(Misconfigured):
        render([Take(tmp_path / "one.mcap", "certified", BEGIN, ())], tmp_path, rate=5.0, speed=2.0)
    assert list(tmp_path.iterdir()) == []
