"""What the contract lets everybody do to a simulation: ``python -m services.sim`` as it is without any option."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image

from shared.messages import CameraImage, FtSample, Header, JointState
from shared.sim_messages import SimWorld
from shared.topics import SENSOR_CAMERA, SENSOR_FT, SIM_WORLD, STATE_JOINTS, Topic
from shared.wire.codec import Rejected, decode
from tests.conftest import Router, _processes
from tests.contract.robot import PATIENCE, Robot, lives_through
from tests.support.wait import eventually

pytestmark = pytest.mark.processes

GUIDED = (1.9, -0.2, 0.95)
"""Where the hands are guided to [m]."""
LIFT = '[[phase]]\ndo = "take_hold"\n[[phase]]\ndo = "lift"\nheight = 0.1\n'


@pytest.fixture(scope="module")
def process(shared_router: Router, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One simulation for all of them."""
    with _processes(tmp_path_factory.mktemp("sim")) as start_process:
        sim = Robot(shared_router.endpoint, "tiago")
        running = start_process("services.sim", environment={"TANDEM_CONNECT": shared_router.endpoint})
        with lives_through(sim, running):
            yield sim


@pytest.fixture
def sim(process: Robot) -> Iterator[Robot]:
    """As it is after a reset."""
    eventually(lambda: process.all(SIM_WORLD), PATIENCE, "it tells of its world")
    yield process
    command(process, "reset")


def command(sim: Robot, name: str, **request: object) -> None:
    """Have it done; what is heard of the world afterwards is from after it."""
    assert sim.ask("sim/command", command=name, **request) == {"ok": True}
    passed(sim, 2)


def passed(sim: Robot, count: int) -> None:
    """Let so many thirtieths of a second pass, by the simulation's own account."""
    before = sim.all(SIM_WORLD)[-1].header.seq
    eventually(lambda: sim.all(SIM_WORLD)[-1].header.seq >= before + count, PATIENCE, "its world goes on")


def world(sim: Robot) -> SimWorld:
    return sim.all(SIM_WORLD)[-1].message


def shows(sim: Robot, condition: Callable[[SimWorld], object], what: str) -> None:
    eventually(lambda: condition(world(sim)), PATIENCE, what)


def test_load_hangs_a_bag_and_takes_it_off(sim: Robot) -> None:
    command(sim, "load", mass=2.0)
    shows(sim, lambda world: world.bag and world.bag.mass == 2.0, "a bag of 2 kg")
    shows(sim, lambda world: abs(world.contact_force[2] + 2.0 * 9.81) < 0.2, "its weight")
    command(sim, "load", mass=0)
    shows(sim, lambda world: world.bag is None, "none")


def test_push_acts_on_the_tool_for_its_duration(sim: Robot) -> None:
    command(sim, "push", force=[0.0, 6.0, 0.0], torque=[0.0, 0.0, 0.2], duration=1.0)
    shows(sim, lambda world: world.contact_force == pytest.approx((0, 6, 0)), "the push")
    shows(sim, lambda world: not world.contact_force.any(), "its end")


@pytest.mark.parametrize(("script", "doing"), [("carry", "wait"), (LIFT, "lift")], ids=["carry", "toml"])
def test_hand_acts_out_a_script(sim: Robot, script: str, doing: str) -> None:
    assert world(sim).hand is None
    command(sim, "hand", script=script)
    shows(sim, lambda world: world.hand and world.hand.doing == doing, f"the person does {doing}")
    if doing == "lift":
        shows(sim, lambda world: world.hand.force[2] > 5.0, "the person carries their share")


def test_hand_is_guided_to_a_target(sim: Robot) -> None:
    command(sim, "hand", target=list(GUIDED))
    shows(sim, lambda world: world.hand and np.allclose(world.hand.wanted, GUIDED), "they are to be there")
    shows(sim, lambda world: world.hand.position[2] > 0.85, "the far end is lifted")


def test_cover_marker_until_it_is_taken_off(sim: Robot) -> None:
    shows(sim, lambda world: world.marker_visible, "the marker")
    command(sim, "cover_marker")
    shows(sim, lambda world: not world.marker_visible, "none")
    command(sim, "cover_marker", covered=False)
    shows(sim, lambda world: world.marker_visible, "the marker again")


def test_reset_takes_everything_back(sim: Robot) -> None:
    start = world(sim).panel.position
    command(sim, "load", mass=1.0)
    command(sim, "hand", target=list(GUIDED))
    command(sim, "cover_marker")
    command(sim, "fault", target="ft", kind="off")
    shows(sim, lambda world: np.linalg.norm(world.panel.position - start) > 0.03, "the panel moves")
    command(sim, "reset")
    shows(sim, lambda world: world.bag is None and world.hand is None and world.marker_visible, "as before")
    assert world(sim).panel.position == pytest.approx(start, abs=1e-3)
    sim.heard[SENSOR_FT.key].clear()
    eventually(lambda: sim.all(SENSOR_FT), PATIENCE, "the sensor speaks")


def measured(message: FtSample | JointState | CameraImage) -> list[float]:
    """What the sensor says: the force, where the right arm's joints are, or the picture's brightness."""
    match message:
        case FtSample():
            return message.force.tolist()
        case CameraImage():
            return [float(np.mean(Image.open(io.BytesIO(message.data)).convert("L")))]
    joints = zip(message.name, message.position.tolist(), strict=True)
    return [position for name, position in joints if name.startswith("arm_right")]


@pytest.mark.parametrize(
    ("target", "topic", "count", "bias", "slack", "delay"),
    [
        ("ft", SENSOR_FT, 10, 3.0, 0.5, 0.3),
        ("joints", STATE_JOINTS, 10, 3.0, 0.5, 0.3),
        # What is black gets no darker.
        ("camera", SENSOR_CAMERA, 3, -60.0, 20.0, 0.8),
    ],
    ids=["ft", "joints", "camera"],
)
def test_fault_of_a_sensor(
    sim: Robot, target: str, topic: Topic, count: int, bias: float, slack: float, delay: float
) -> None:
    with sim.listening(topic.key) as samples:

        def arrived() -> list[bytes]:
            samples.clear()
            eventually(lambda: len(samples) >= count, PATIENCE, f"{count} messages")
            return [sample.payload.to_bytes() for sample in samples][-(count + 1) // 2 :]

        def messages() -> list[tuple[Header, Any]]:
            return [decode(topic.message, payload, topic.cap) for payload in arrived()]

        def level() -> np.ndarray:
            return np.mean([measured(message) for _, message in messages()], axis=0)

        def silent() -> bool:
            samples.clear()
            passed(sim, 15)
            return not samples

        def garbage() -> bool:
            try:
                return not messages()
            except Rejected:
                return True

        def stuck() -> bool:
            return len({str(measured(message)) for _, message in messages()}) == 1

        def lag() -> float:
            # World and sensor stamp with one clock: what is delayed says so.
            header, _ = messages()[-1]
            return (sim.all(SIM_WORLD)[-1].header.stamp - header.stamp) * 1e-9

        right = level()
        command(sim, "fault", target=target, kind="off")
        eventually(silent, PATIENCE, "silence")
        command(sim, "fault", target=target, kind="garbage")
        eventually(garbage, PATIENCE, "garbage")
        command(sim, "fault", target=target, kind="stuck")
        eventually(lambda: not garbage() and stuck(), PATIENCE, "the same again and again")
        command(sim, "fault", target=target, kind="bias", value=bias)
        eventually(lambda: np.allclose(level(), right + bias, atol=slack), PATIENCE, f"{bias} more")
        command(sim, "fault", target=target, kind="delay", value=delay)
        eventually(lambda: lag() > 0.8 * delay, PATIENCE, "old messages")
        command(sim, "fault", target=target, kind="ok")
        eventually(lambda: lag() < delay / 3.0, PATIENCE, "fresh ones")
        assert level() == pytest.approx(right, abs=min(slack, 5.0))
    sim.rejected.clear()
