"""The simulator as everybody sees it: its scenes, its rates, and its gate through the motion and ``state/robot``."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest

from services.sim.camera.render_process import RenderProcess
from services.sim.camera.renderer import Renderer
from services.sim.parameters import SimParameters
from services.sim.robot.arm import DRIVE_LAG
from services.sim.simulator import Simulator
from shared import topics
from shared.loop.stack import Stack
from shared.messages import Stop, TwistCommand
from shared.topics import Topic
from tests.services.sim.rig import Rig

DOWN = (0.0, 0.0, -0.1)
RATES = ((30.0, 100.0), (100.0, 50.0), (250.0, 100.0), (500.0, 500.0))
"""Of wrist sensor and joints [Hz]."""


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_without_commands_it_holds_and_says_why(rig: Rig) -> None:
    status = rig.last(topics.STATE_ROBOT)
    assert (status.mode, status.simulated, status.base_type) == ("holding", True, "differential")
    assert status.reason == "no fresh command"
    assert status.max_linear == 0.3 and status.max_angular == 1.0


def test_a_fresh_command_moves_it_and_silence_stops_it(rig: Rig) -> None:
    rig.move(DOWN, 0.3)
    assert rig.last(topics.STATE_ROBOT).mode == "ready"
    assert rig.speed == pytest.approx(0.1, rel=0.02)
    # 20 ms of ttl, then the drives' lag.
    rig.run(0.02 + 6 * DRIVE_LAG)
    assert rig.speed < 1e-3
    rig.run(0.05)
    assert rig.last(topics.STATE_ROBOT).mode == "holding"
    height = rig.height
    rig.run(1.0)
    assert "commands expired: 1" in rig.last(topics.STATE_ROBOT).reason
    assert rig.height == pytest.approx(height, abs=1e-4)


@pytest.mark.parametrize("ttl", [0.004, 0.01, 0.05, 0.2, 100.0])
def test_a_command_acts_for_its_ttl_to_within_a_physics_step(rig: Rig, ttl: float) -> None:
    start, acts = rig.height, min(ttl, 0.2)
    rig.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.1), (0, 0, 0), ttl))
    rig.run(acts + 0.3)
    # Speeding up from 0 to 0.1 m/s at 5 m/s2 takes 20 ms; the lag delays motion but takes nothing from it.
    rise = min(acts, 0.02)
    travel = 0.5 * 5.0 * rise**2 + 0.1 * (acts - rise)
    assert start - rig.height == pytest.approx(travel, abs=0.1 * 0.0021)
    assert ("commands clamped: 1" in rig.last(topics.STATE_ROBOT).reason) == (ttl > acts)


def test_a_stop_brakes_within_20_ms_and_ends_with_its_release(rig: Rig) -> None:
    rig.move(DOWN, 0.2)
    rig.stack.client.publish(topics.STOP, Stop(True, "somebody shouted"))
    rig.move(DOWN, 0.02)
    assert rig.simulator.side.mode == "stopped"
    rig.move(DOWN, 1.0)
    assert rig.speed < 1e-3
    rig.stack.client.publish(topics.STOP, Stop(False, ""))
    rig.move(DOWN, 0.3)
    assert rig.speed == pytest.approx(0.1, rel=0.05)


def test_what_the_arm_cannot_do_is_told(rig: Rig) -> None:
    rig.move((0, 0, 0.3), 2.0)
    assert "limit" in rig.last(topics.STATE_ROBOT).reason or "singular" in rig.last(topics.STATE_ROBOT).reason


def test_the_gate_works_in_real_time_whatever_the_real_time_factor() -> None:
    rig = Rig(real_time_factor=2.0)
    start = rig.height
    rig.stack.client.publish(topics.COMMAND_EE_TWIST, TwistCommand((0, 0, -0.1), (0, 0, 0), 0.1))
    rig.run(0.5)
    travel = 0.5 * 5.0 * 0.02**2 / 2 + 0.1 * (0.2 - 0.02)
    assert start - rig.height == pytest.approx(travel, abs=3e-3)
    assert rig.last(topics.SIM_WORLD).time == pytest.approx(2 * rig.stack.now, abs=0.1)


START = (0.5, -0.3, 1.0)
"""Of the tool [m] for the load experiment."""


@pytest.mark.parametrize(
    ("scene", "start", "edge"),
    [("full", START, (0.64, -0.27, 0.78)), ("load", START, None), ("carry", (0.45, -0.39, 0.78), (0.57, -0.39, 0.78))],
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


@pytest.mark.parametrize(
    ("settings", "ft_rate", "joint_rate"),
    [
        *(({"ft_rate": ft, "joint_rate": joint}, ft, joint) for ft, joint in RATES),
        # A tenth of real time: everything still comes often enough.
        ({"real_time_factor": 0.1, "ft_rate": 300.0, "joint_rate": 300.0}, 30.0, 30.0),
    ],
)
def test_topics_come_at_their_rates(settings: dict[str, float], ft_rate: float, joint_rate: float) -> None:
    slow = settings.get("real_time_factor", 1.0)
    rig, duration = Rig(**settings), 2.0 if slow == 1.0 else 4.0
    before = {key: len(received) for key, received in rig.received.items()}
    rig.run(duration)
    for key, rate in (
        ("sensor/ft", ft_rate),
        ("state/joints", joint_rate),
        ("state/ee", joint_rate),
        ("state/base", 50 if slow == 1.0 else 30),
        ("state/gripper", 20),
        ("state/robot", 5),
        ("sim/world", 30),
    ):
        late = 2 if slow == 1.0 else 3
        assert len(rig.received[key]) - before[key] == pytest.approx(duration * rate, abs=late), key
    assert rig.last(topics.SIM_WORLD).time == pytest.approx(slow * rig.stack.now, abs=0.05)
    stamps = [received.header.stamp for received in rig.received["sensor/ft"]]
    assert np.diff(stamps) == pytest.approx(1e9 / ft_rate, abs=1e4)


def test_a_reset_is_another_run_of_the_robot_at_its_start(rig: Rig) -> None:
    def session(topic: Topic) -> int:
        return rig.received[topic.key][-1].header.session

    arm, states = rig.simulator.world.arm, [topic for topic in topics.TOPICS if topic.key.startswith("state/")]
    start = arm.tool_position.copy()
    rig.move(DOWN, 0.5)
    sensor, sessions = session(topics.SENSOR_FT), {session(topic) for topic in states}
    rig.ask(command="reset")
    # Nobody takes a second session before the first one's silence of up to a second.
    rig.run(1.5)
    assert arm.tool_position == pytest.approx(start, abs=1e-4), "the last command was meant for where the robot was"
    renewed = {session(topic) for topic in states}
    assert len(sessions) == len(renewed) == 1 and sessions != renewed
    assert session(topics.SENSOR_FT) == sensor
