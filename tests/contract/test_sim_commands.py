"""What the contract lets everybody do to a simulation: ``python -m services.sim`` as it is without any option."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator

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


def measured(message: FtSample | JointState) -> list[float]:
    """What the sensor says: the force, or where the right arm's joints are."""
    if isinstance(message, FtSample):
        return message.force.tolist()
    joints = zip(message.name, message.position.tolist(), strict=True)
    return [position for name, position in joints if name.startswith("arm_right")]


@pytest.mark.parametrize(
    ("target", "topic"), [("ft", SENSOR_FT), ("joints", STATE_JOINTS)], ids=["ft", "joints"]
)
def test_fault_of_a_sensor(sim: Robot, target: str, topic: Topic) -> None:
    def values(count: int = 10) -> list[list[float]]:
        sim.heard[topic.key].clear()
        eventually(lambda: len(sim.all(topic)) >= count, PATIENCE, f"{count} messages")
        return [measured(heard.message) for heard in sim.all(topic)[-count // 2 :]]

    def silent() -> bool:
        sim.heard[topic.key].clear()
        passed(sim, 6)
        return not sim.all(topic)

    right = np.mean(values(), axis=0)
    command(sim, "fault", target=target, kind="off")
    eventually(silent, PATIENCE, "silence")
    command(sim, "fault", target=target, kind="garbage")
    rejected = len(sim.rejected)
    eventually(lambda: len(sim.rejected) > rejected + 5, PATIENCE, "garbage")
    sim.rejected.clear()
    command(sim, "fault", target=target, kind="stuck")
    eventually(lambda: len({tuple(value) for value in values()}) == 1, PATIENCE, "the same again and again")
    command(sim, "fault", target=target, kind="bias", value=3.0)
    eventually(lambda: np.allclose(np.mean(values(), axis=0), right + 3.0, atol=0.5), PATIENCE, "3 more")
    command(sim, "fault", target=target, kind="delay", value=0.3)
    # World and sensor stamp with one clock: what is delayed says so.
    eventually(lambda: lag(sim, topic) > 0.25, PATIENCE, "old messages")
    command(sim, "fault", target=target, kind="ok")
    eventually(lambda: lag(sim, topic) < 0.1, PATIENCE, "fresh ones")
    assert np.mean(values(), axis=0) == pytest.approx(right, abs=0.5)


def lag(sim: Robot, topic: Topic) -> float:
    """How much older [s] the newest message of a topic is than the newest of the world."""
    heard = sim.all(topic)
    return (sim.all(SIM_WORLD)[-1].header.stamp - heard[-1].header.stamp) * 1e-9 if heard else float("inf")


def test_fault_of_the_camera(sim: Robot) -> None:
    with sim.listening(SENSOR_CAMERA.key) as samples:

        def arrived(count: int = 3) -> list[bytes]:
            samples.clear()
            eventually(lambda: len(samples) >= count, PATIENCE, f"{count} pictures")
            return [sample.payload.to_bytes() for sample in samples]

        def picture() -> tuple[Header, CameraImage]:
            return decode(CameraImage, arrived()[-1], SENSOR_CAMERA.cap)

        def brightness() -> float:
            return float(np.mean(Image.open(io.BytesIO(picture()[1].data)).convert("L")))

        def silent() -> bool:
            samples.clear()
            passed(sim, 15)
            return not samples

        def garbage() -> bool:
            try:
                picture()
            except Rejected:
                return True
            return False

        right = brightness()
        command(sim, "fault", target="camera", kind="off")
        eventually(silent, PATIENCE, "silence")
        command(sim, "fault", target="camera", kind="garbage")
        eventually(garbage, PATIENCE, "garbage")
        command(sim, "fault", target="camera", kind="bias", value=-60.0)
        eventually(lambda: not garbage() and brightness() < right - 40.0, PATIENCE, "a darker picture")
        command(sim, "fault", target="camera", kind="stuck")
        eventually(lambda: picture()[1].data == picture()[1].data, PATIENCE, "one picture for ever")
        command(sim, "fault", target="camera", kind="delay", value=0.8)
        eventually(
            lambda: -picture()[0].stamp + sim.all(SIM_WORLD)[-1].header.stamp > 0.7e9, PATIENCE, "old ones"
        )
        command(sim, "fault", target="camera", kind="ok")
        eventually(lambda: abs(brightness() - right) < 5.0, PATIENCE, "as before")
