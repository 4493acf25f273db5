"""What is around the robot: by default everything, and nothing that costs time or is in the way before it is used."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest

from services.sim.camera.render_process import RenderProcess
from services.sim.camera.renderer import Renderer
from services.sim.parameters import SimParameters
from services.sim.simulator import Simulator
from shared import topics
from shared.loop.stack import Stack
from shared.parameters import Refused
from tests.services.sim.rig import Rig

START = (0.5, -0.3, 1.0)
"""Of the tool [m] for the load experiment."""


@pytest.mark.parametrize(
    ("scene", "start", "edge"),
    [
        ("full", START, (0.64, -0.27, 0.78)),
        ("load", START, None),
        ("carry", (0.45, -0.39, 0.78), (0.57, -0.39, 0.78)),
    ],
)
def test_each_scene_has_its_start_and_its_panel(
    scene: str, start: tuple[float, ...], edge: tuple[float, ...] | None
) -> None:
    rig = Rig(scene=scene, camera_rate=1.0)
    assert rig.last(topics.STATE_EE).position == pytest.approx(start, abs=2e-3)
    panel = rig.last(topics.SIM_WORLD).panel
    assert (panel is None) == (edge is None)
    if edge is not None:
        assert panel.position == pytest.approx(np.add(edge, (0.6, 0.0, 0.0)), abs=1e-3)


def test_by_default_it_is_all_of_it_and_a_place_that_is_given_holds_in_every_scene() -> None:
    assert SimParameters().scene == "full"
    for scene in ("full", "carry"):
        assert SimParameters.of({"scene": scene, "panel_position": [0.8, 0.0, 0.9]}).panel_position == (
            0.8,
            0.0,
            0.9,
        )
    with pytest.raises(Refused, match="scene is 'sea', wanted one of 'full', 'load', 'carry'"):
        SimParameters.of({"scene": "sea"})


def test_the_panel_is_not_in_the_way_of_a_tool_that_is_lowered_from_its_start() -> None:
    samples = {}
    for scene in ("load", "full"):
        rig = Rig(scene=scene, camera_rate=1.0)
        rig.move((0.0, 0.0, -0.1), 4.3)
        rig.run(0.3)
        assert rig.height == pytest.approx(0.58, abs=0.02)
        samples[scene] = np.array([(*sample.force, *sample.torque) for sample in rig.all(topics.SENSOR_FT)])
        assert all(not world.contact_force.any() for world in rig.all(topics.SIM_WORLD))
    assert np.array_equal(samples["load"], samples["full"])
    panels = [world.panel.position for world in rig.all(topics.SIM_WORLD)]
    assert np.ptp(panels, axis=0) == pytest.approx(0.0, abs=1e-6)


def test_nobody_looks_nothing_is_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    pictures = []
    monkeypatch.setattr(Renderer, "picture", lambda *_: pictures.append(1))
    stack = Stack()
    stack.add(Simulator(SimParameters()))
    stack.run(1.0)
    assert pictures == []


def test_the_process_that_renders_is_started_for_whom_looks_first(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: started.append(1))
    stack = Stack()
    stack.add(Simulator(SimParameters(), RenderProcess))
    stack.run(1.0)
    assert started == []
    for _ in range(2):
        stack.client.watch(topics.SENSOR_CAMERA)
        stack.run(0.5)
        assert started == [1]
