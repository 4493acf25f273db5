"""What the service takes for a zero, a payload and a living sensor; what it says of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.wrench.parameters import WrenchParameters
from shared.parameters import Refused
from shared.spatial import Array, rotation_from_vector
from shared.topics import WRENCH_IDENTIFY, WRENCH_TARE
from tests.services.wrench.rig import Rig, bounds_hold, identified
from tests.services.wrench.sensor import TILTED, Sensor

PUSH = np.array((20.0, 0, 0, 0, 0, 0))


class Wrong(Sensor):
    """A sensor whose readings are not those that are wanted."""

    def __init__(self, axes: Array | None = None, in_base: bool = False) -> None:
        super().__init__(noise=np.array((0.02, 0.02, 0.02, 0.001, 0.001, 0.001)))
        self.axes, self.in_base = np.eye(3) if axes is None else axes, in_base

    def exact(self, rotation: Array, external: Array | None = None) -> Array:
        axes = rotation if self.in_base else self.axes
        return np.kron(np.eye(2), axes) @ super().exact(rotation, external)


def test_a_tare_under_a_push_is_refused_and_taken_by_force_only() -> None:
    rig = Rig()
    rig.external = PUSH
    rig.run(0.5)
    rig.refuses(r"\w+ [xy] reads .* Does something touch the tool.*`force` adopts it", WRENCH_TARE, {"duration": 0.5})
    rig.run(0.1)
    assert rig.last.message.compensation == "none" and rig.wrench.notes() == ""
    answer = rig.ask(WRENCH_TARE, {"duration": 0.5, "force": True})
    assert "touch the tool" in answer["warning"]
    rig.run(0.1)
    assert "adopted by force" in rig.wrench.notes() and "bias_bound is refuted" in rig.wrench.notes()
    rig.external = np.zeros(6)
    rig.run(0.1)
    assert rig.tare()["warning"] == ""
    rig.settle(0.1)
    assert "by force" not in rig.wrench.notes() and bounds_hold(rig, np.zeros(6))


def test_a_touch_within_the_bias_bound_is_seen_by_the_former_zero_only() -> None:
    rig = Rig()
    rig.run(0.5)
    rig.tare()
    rig.external = 0.1 * PUSH
    rig.settle(0.2)
    rig.refuses("from the zero of", WRENCH_TARE, {"duration": 0.5})
    fresh = Rig()
    fresh.external = 0.05 * PUSH
    fresh.run(0.5)
    assert fresh.tare()["warning"] == "", "nothing tells it from a bias: it is the person's word"


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        (Wrong(rotation_from_vector((0, 0, math.pi / 4))), "turned by 45 degrees about z would fit, rms 0.00"),
        (Wrong(rotation_from_vector((0, 0, math.radians(20)))), "turned by 20 degrees about z would fit"),
        (Wrong(-np.eye(3)), r"pulls upwards.*the opposite sign would fit"),
        (Wrong(in_base=True), "base axes"),
    ],
)
def test_an_identification_that_does_not_explain_its_poses_is_refused(sensor: Sensor, words: str) -> None:
    rig = Rig()
    rig.sensor = sensor
    rig.run(0.2)
    rig.identify("start")
    for rotation in TILTED:
        rig.rotation = rotation
        rig.run(0.05)
        rig.identify("add")
    rig.refuses(words, WRENCH_IDENTIFY, {"action": "solve"})
    rig.run(0.1)
    assert rig.last.message.compensation == "none"


def test_the_opposite_sign_shows_at_the_tare() -> None:
    rig = Rig(bias_bound=(3.0, 3.0, 3.0, 0.3, 0.3, 0.3))
    rig.sensor = Wrong(-np.eye(3))
    rig.run(0.2)
    rig.refuses("Are the readings of the opposite sign", WRENCH_TARE, {"duration": 0.5})


def test_a_forced_payload_says_so_as_long_as_it_counts() -> None:
    rig = Rig(tool_mass=0.5)
    rig.run(0.2)
    with pytest.raises(Refused, match=r"tool_mass declares 0\.5 kg"):
        identified(rig)
    answer = rig.ask(WRENCH_IDENTIFY, {"action": "solve", "force": True})
    assert answer["mass"] == pytest.approx(0.82, abs=0.05) and "tool_mass" in answer["warning"]
    rig.run(0.1)
    assert rig.last.message.compensation == "payload" and "adopted by force" in rig.wrench.notes()


def test_a_sensor_without_noise_works_and_one_that_stops_following_its_weight_does_not() -> None:
    rig = Rig()
    rig.sensor.noise = np.zeros(6)
    received = rig.heard(2.5)
    assert all(r.header.valid for r in received)
    assert "simulator without noise" in rig.wrench.notes()
    rig.tare()
    rig.external = PUSH
    rig.settle(1.0)
    assert rig.last.header.valid and "force x" not in rig.wrench.notes()
    rig.stuck = [0]
    rig.rotation = rotation_from_vector((0.0, 0.5, 0.0))
    rig.settle(0.1)
    assert rig.last.message.fault == "stuck"


def test_a_reading_beyond_the_range_is_invalid_and_at_it_saturated() -> None:
    rig = Rig(sensor_range=(50.0, 50.0, 50.0, 5.0, 5.0, 5.0))
    rig.run(0.5)
    rig.external = 3 * PUSH
    rig.settle(0.1)
    assert rig.last.message.fault == "invalid" and not rig.last.header.valid
    assert "sensor_range" in rig.wrench.notes()
    rig.external = np.zeros(6)
    rig.settle(0.1)
    assert rig.last.header.valid


CONTRADICTIONS: dict[str, dict[str, object]] = {
    "lowpass_hz is 1": {"lowpass_hz": 1.0},
    "noise_bound, bias_bound and resolution are 5.5 N together": {"sensor_range": (5.0,) * 6},
    "is beyond sensor_range": {"tool_mass": 40.0, "sensor_range": (100.0,) * 6},
}


@pytest.mark.parametrize("words", CONTRADICTIONS)
def test_parameters_that_contradict_each_other_are_refused(words: str) -> None:
    with pytest.raises(Refused, match=words):
        WrenchParameters.of(CONTRADICTIONS[words])


@pytest.mark.parametrize(
    ("given", "words"), [({"stuck_after": 0.02}, "stuck axis shows after 0.07 s"), ({"lowpass_hz": 30.0}, "no effect")]
)
def test_parameters_that_do_not_fit_the_rate_are_told(given: dict[str, float], words: str) -> None:
    slow, fast = Rig(rate=30.0, **given), Rig(rate=500.0, **given)
    for rig in (slow, fast):
        rig.run(5.0)
    assert words in slow.wrench.notes() and fast.wrench.notes() == ""


def test_noise_beyond_the_declared_counts_and_is_said() -> None:
    rig = Rig(noise_bound=(0.2, 0.5, 0.5, 0.025, 0.025, 0.025))
    rig.run(0.5)
    rig.tare()
    rig.run(0.1)
    assert "noise_bound is refuted" in rig.wrench.notes()
    assert rig.last.message.error_bound[0] > 0.4
