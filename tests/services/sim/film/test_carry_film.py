"""The film of a carry and its strip of stills: what is in the pictures is what was recorded."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from services.sim.film.carry_recording import CarryRun, Moment
from services.sim.film.carry_scene import CarryScene
from services.sim.film.figure import FOREARM, UPPER_ARM, posture
from services.sim.scene.panel import CLEARED
from shared import topics
from shared.messages import HeadCommand
from tests.services.sim.carries import ROWS, START, carry
from tests.services.sim.rig import Rig

SIZE = (480, 270)


@pytest.fixture
def run() -> CarryRun:
    return CarryRun(carry())


@pytest.fixture
def scene(run: CarryRun) -> Iterator[CarryScene]:
    scene = CarryScene(run.scenery, SIZE)
    yield scene
    scene.close()


def panel_in(picture: np.ndarray) -> np.ndarray:
    """Which pixels (height, width) are blue as the panel: much bluer than red, and bright."""
    red, _, blue = np.moveaxis(picture.astype(int), 2, 0)
    return (blue - red > 35) & (blue > 140)


def test_the_panel_appears_where_it_is_and_moves(run: CarryRun, scene: CarryScene) -> None:
    places = []
    for time in (10.0, 12.0):
        moment = run.at(time)
        blue = panel_in(scene.picture(moment))
        on_it = moment.panel + np.array([(x, y, 0.025) for x in (-0.5, 0.0, 0.5) for y in (-0.22, 0.22)])
        beside = moment.panel + np.array([(x, y, 0.025) for x in (-0.2, 0.4) for y in (-0.5, 0.5)])
        columns, rows = np.floor(scene.pixel(on_it)).astype(int).T
        assert blue[rows, columns].all()
        columns, rows = np.floor(scene.pixel(beside)).astype(int).T
        assert not blue[rows, columns].any()
        places.append(scene.pixel(moment.panel))
    assert np.linalg.norm(places[1] - places[0]) > 10.0


def test_the_view_follows_the_base(run: CarryRun, scene: CarryScene) -> None:
    places = []
    for time in np.linspace(10.0, 14.0, 9):
        moment = run.at(time)
        scene.picture(moment)
        places.append(scene.pixel((*moment.base[:2], 0.5)))
    assert np.ptp(places, axis=0).max() < 0.12 * SIZE[0]
    for corner in ((-0.3, -0.5), (2.3, 0.6)):
        column, row = scene.pixel((*(moment.base[:2] + corner), 0.9))
        assert 0 < column < SIZE[0] and 0 < row < SIZE[1]


def test_trestles_are_there_until_the_panel_is_lifted(run: CarryRun) -> None:
    standing = [run.at(time).trestles is not None for time in run.time]
    assert standing[0] and not standing[-1]
    lift = run.at(run.time[standing.index(False)]).panel[2] - START[2]
    assert lift == pytest.approx(CLEARED, abs=0.02)


def test_the_marker_is_seen_until_it_is_covered(run: CarryRun, scene: CarryScene) -> None:
    covered = [run.at(time).covered for time in run.time]
    assert not covered[0] and covered[-1]
    with_marker, without = run.at(10.0), run.at(10.0)
    object.__setattr__(without, "covered", True)
    changed = np.abs(scene.picture(with_marker).astype(int) - scene.picture(without)).sum(axis=2) > 60
    column, row = scene.pixel(np.array(START) + run.scenery.marker_in_panel)
    rows, columns = np.nonzero(changed)
    assert (columns.mean(), rows.mean()) == pytest.approx((column, row), abs=6)


def test_the_head_camera_s_view_is_the_one_of_the_simulation() -> None:
    rig = Rig(scene="carry", base_type="omni")
    rig.drive((-0.05, 0.1, -0.1), 1.0)
    rig.stack.client.publish(topics.COMMAND_HEAD, HeadCommand(-0.2, -0.5))
    rig.run(2.0)
    joints, base = rig.last(topics.STATE_JOINTS), rig.last(topics.STATE_BASE)
    panel = rig.last(topics.SIM_WORLD).panel
    run = CarryRun(
        carry(
            parameters={"scene": "carry"},
            joint_names=np.array(joints.name),
            joint_positions=np.tile(joints.position, (ROWS, 1)),
            base=np.tile((*base.position, base.yaw), (ROWS, 1)),
            panel_position=np.tile(panel.position, (ROWS, 1)),
            panel_orientation=np.tile(panel.orientation, (ROWS, 1)),
        )
    )
    told, true = run.view(run.at(10.0)), rig.simulator._camera.view()
    for name in ("position", "rotation", "panel", "panel_rotation"):
        assert getattr(told, name) == pytest.approx(getattr(true, name), abs=1e-3), name
    assert told.supports[0] == pytest.approx(true.supports[0], abs=1e-3)
    assert told.supports[1] == pytest.approx(true.supports[1], abs=1e-3)
    assert {name: told.joints[name] for name in true.joints} == pytest.approx(true.joints, abs=1e-3)


@pytest.mark.parametrize("height", [0.3, 0.6, 0.95])
@pytest.mark.parametrize("upright", [False, True])
def test_a_person_reaches_the_panel_with_limbs_of_their_length(height: float, upright: bool) -> None:
    edge = np.array((1.7, -0.4, height))
    across = np.array((0.0, 0.0, 1.0)) if upright else np.array((0.0, 1.0, 0.0))
    stance = posture(edge, across, np.array((1.0, 0.0, 0.0)), 1.0)
    assert stance.hands.mean(axis=0) == pytest.approx(edge)
    for shoulder, elbow, hand in zip(stance.shoulders, stance.elbows, stance.hands, strict=True):
        assert np.linalg.norm(elbow - shoulder) == pytest.approx(UPPER_ARM)
        assert np.linalg.norm(hand - elbow) == pytest.approx(FOREARM, abs=0.1)
    assert stance.knees[:, 2].min() > 0.2 and stance.head[2] > height


def test_the_hands_go_to_the_panel_and_do_not_jump(run: CarryRun) -> None:
    moments: list[Moment] = [run.at(time) for time in run.time]
    shares = [moment.holding for moment in moments]
    assert shares[0] == 0.0 and shares[-1] == 1.0
    assert np.diff(shares).min() >= 0.0 and np.diff(shares).max() < 0.25
