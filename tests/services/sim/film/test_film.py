"""Films of both experiments, the load's scene, and recordings that no film can be made of."""

from __future__ import annotations

from pathlib import Path

import imageio.v2 as imageio
import numpy as np
import pytest

from services.sim.film import carry_film, load_film
from services.sim.film.film import FILM, STRIP, render
from services.sim.film.load_scene import Scene
from services.sim.robot.kinematics import HOME
from shared.loop.config import Misconfigured
from shared.robot.tiago import CHAIN
from tests.services.sim.carries import SECONDS, carry


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


@pytest.mark.parametrize(
    ("made", "rate", "pictures", "shape"),
    [
        (recording(), 5.0, 5, (load_film.HEIGHT, load_film.WIDTH, 3)),
        (carry(), 4.0, round(SECONDS), (carry_film.HEIGHT, carry_film.WIDTH, 3)),
    ],
    ids=["load", "carry"],
)
def test_a_film_has_its_length_and_its_pictures_change(
    tmp_path: Path, made: dict[str, object], rate: float, pictures: int, shape: tuple[int, ...]
) -> None:
    assert render(made, tmp_path, rate=rate, speed=4.0) == pictures
    shown = [np.asarray(picture, dtype=float) for picture in imageio.get_reader(tmp_path / FILM)]
    assert len(shown) == pictures and shown[0].shape == shape
    assert np.abs(shown[0] - shown[-1]).mean() > 1.0
    if made["scene"] != "carry":
        return
    strip = imageio.imread(tmp_path / STRIP)
    # Pictures are parted by white lines; captions above them belong to none.
    below = strip[-carry_film.STILL[1] :]
    filled = (below != 255).any(axis=(0, 2)).astype(int)
    assert (np.diff(filled) == 1).sum() == 3
    assert filled.sum() == 3 * carry_film.STILL[0]


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
    ("made", "says"),
    [
        (recording(force_z=None), "no recording of a run"),
        (recording(scene="carry"), "no recording of a run"),
        (recording(force_z=np.zeros(3)), "series of one length"),
        (recording(joint_positions=np.zeros((40, 2))), "joint_positions has shape (40, 2), wanted (40, 8)"),
        (carry(hand_force=None), "no recording of a run"),
        (carry(wrench=np.zeros((3, 6))), "series of one length"),
        (carry(parameters={"marker_id": 99}), "parameters: "),
    ],
)
def test_a_bad_recording_is_refused_in_one_line(tmp_path: Path, made: dict[str, object], says: str) -> None:
    with pytest.raises(Misconfigured) as refused:
        render(made, tmp_path)
    assert says in str(refused.value) and "\n" not in str(refused.value)


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="nowhere"):
        render(recording(), tmp_path / "nowhere")
