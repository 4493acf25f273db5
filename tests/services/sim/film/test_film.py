"""The film of the load experiment, and recordings that no film can be made of."""

from __future__ import annotations

from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from services.sim.film.film import FILM, render
from services.sim.film.load_film import HEIGHT, WIDTH
from services.sim.film.load_scene import Scene
from services.sim.robot.kinematics import HOME
from shared.loop.config import Misconfigured
from shared.robot.tiago import CHAIN


def recording(**changes: object) -> dict[str, object]:
    rows = 40
    joints = np.tile([HOME[name] for name in CHAIN], (rows, 1))
    joints[:, 0] -= np.linspace(0, 0.3, rows)
    data = {
        "scene": "load",
        "time": np.linspace(0, 4, rows),
        "joint_names": np.array(CHAIN),
        "joint_positions": joints,
        "bag_mass": np.where(np.arange(rows) > 10, 2.0, 0.0),
        "bag_height": np.where(np.arange(rows) > 10, np.linspace(0.4, 0.0, rows), np.nan),
        "force_z": np.linspace(0, -30, rows),
        "limit_z": 25.0,
    }
    return {name: value for name, value in (data | changes).items() if value is not None}


def test_a_film_has_its_length_and_its_pictures_change(tmp_path: Path) -> None:
    assert render(recording(), tmp_path, rate=5.0, speed=4.0) == 5
    pictures = [np.asarray(picture, dtype=float) for picture in imageio.get_reader(tmp_path / FILM)]
    assert len(pictures) == 5
    assert pictures[0].shape == (HEIGHT, WIDTH, 3)
    assert np.abs(pictures[0] - pictures[-1]).mean() > 1.0


def test_the_tool_appears_where_the_camera_says() -> None:
    scene = Scene(320, 240)
    try:
        scene.pose(HOME, None)
        without = scene.picture().astype(int)
        column, row = scene.pixel(scene.tool())
        scene.pose(HOME, scene.tool()[2] - 0.6)
        changed = np.argwhere(np.abs(scene.picture().astype(int) - without).sum(axis=2) > 30)
        # The rope begins at the tool.
        top = changed[changed[:, 0].argmin()]
        assert top == pytest.approx((row, column), abs=8)
    finally:
        scene.close()


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"force_z": None}, "no recording of a run"),
        ({"scene": "carry"}, "no recording of a run"),
        ({"force_z": np.zeros(3)}, "series of one length"),
        ({"joint_positions": np.zeros((40, 2))}, "joint_positions has shape (40, 2), wanted (40, 8)"),
    ],
)
def test_a_bad_recording_is_refused_in_one_line(
    tmp_path: Path, changes: dict[str, object], says: str
) -> None:
    with pytest.raises(Misconfigured) as refused:
        render(recording(**changes), tmp_path)
    assert says in str(refused.value) and "\n" not in str(refused.value)


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        render(recording(), tmp_path / "nowhere")
