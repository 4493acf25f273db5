"""The viewer without a window: it shows the time that it is asked for, or says why not, and leaves nothing behind."""

from __future__ import annotations

import os
import random
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb

from services.viewer.stream import Stream
from services.viewer.windowless import Windowless
from shared.loop.config import Misconfigured
from tests.services.cli.command import exists
from tests.support import vulkan

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SIZE = (320, 240)
GREYS = 16


@pytest.fixture(scope="module")
def stream() -> Iterator[Stream]:
    """A picture that is a shade brighter each second."""
    with Stream.served("127.0.0.1", 0) as made:
        for second in range(GREYS):
            made.rec.set_time("time", duration=float(second))
            made.rec.log("grey", rr.Image(np.full((6, 8), 16 * second, np.uint8), color_model="L"))
        hidden = rrb.TopPanel(state="hidden"), rrb.TimePanel(state="hidden"), rrb.BlueprintPanel(state="hidden")
        view = rrb.Spatial2DView(origin="grey", titlebar=False)
        made.rec.send_blueprint(rrb.Blueprint(view, *hidden, rrb.SelectionPanel(state="hidden"), auto_views=False))
        made.rec.flush()
        yield made


def test_a_picture_shows_the_time_that_was_asked_for(stream: Stream) -> None:
    vulkan.wanted()
    asked = random.Random(1).choices(range(GREYS), k=24)
    with Windowless(stream.uri, SIZE, GREYS - 1.0) as viewer:
        pictures = [viewer.picture(second + 0.5) for second in asked]
    assert {picture.shape for picture in pictures} == {(SIZE[1], SIZE[0], 3)}
    assert [round(picture[120, 160].mean() / 16.0) for picture in pictures] == asked


def test_shaders_are_kept_where_nobody_has_a_home(
    stream: Stream, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    vulkan.wanted()
    monkeypatch.setenv("HOME", "/proc")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with Windowless(stream.uri, SIZE, GREYS - 1.0) as viewer:
        viewer.picture(1.0)
        assert any(path.is_file() for path in tmp_path.rglob("*"))
    assert not list(tmp_path.iterdir())


def test_nothing_is_left_of_it_and_one_that_was_killed_is_told(stream: Stream) -> None:
    vulkan.wanted()
    with Windowless(stream.uri, SIZE, GREYS - 1.0) as viewer:
        process = viewer._process.pid
        os.kill(process, signal.SIGKILL)
        with pytest.raises(Misconfigured, match=r"^rerun's viewer ended with status -9$"):
            viewer.picture(1.0)
    assert not exists(process)


def test_without_a_driver_the_remedy_is_told_in_one_line(stream: Stream, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES"):
        monkeypatch.setenv(name, "/nowhere.json")
    # Where a card draws otherwise there is no need of it.
    monkeypatch.setenv("WGPU_BACKEND", "vulkan")
    with pytest.raises(Misconfigured, match=r"^rerun's viewer ended .* apt-get install mesa-vulkan-drivers$"):
        Windowless(stream.uri, SIZE, GREYS - 1.0)


def test_without_the_program_the_package_is_named(stream: Stream, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(Misconfigured, match="not installed: pip install"):
        Windowless(stream.uri, SIZE, 1.0)
