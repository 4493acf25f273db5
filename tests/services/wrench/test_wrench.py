"""The service in simulated time: outputs, faults, queries."""

from __future__ import annotations

import math

import numpy as np
import pytest

from services.wrench.lowpass import LowPass
from shared.spatial import rotation_from_vector
from shared.topics import WRENCH_IDENTIFY, WRENCH_PARAMETERS, WRENCH_TARE
from tests.services.wrench.rig import BAG, Rig, bounds_hold, identified
from tests.services.wrench.sensor import DOWN, TILTED


@pytest.mark.parametrize("rate", [30.0, 100.0, 500.0])
def test_one_valid_wrench_per_sample(rate: float) -> None:
    rig = Rig(rate=rate)
    rig.run(0.1)
    received = rig.heard(2.0)
    assert len(received) == pytest.approx(2.0 * rate, abs=1)
    assert all(r.header.valid and r.message.fault == "" for r in received)


def test_nothing_is_published_before_the_first_sample() -> None:
    rig = Rig()
    rig.on = False
    assert rig.heard(1.0) == []


def test_untared_reading_is_published_as_such_with_a_bound_that_covers_the_weight() -> None:
    rig = Rig()
    rig.external = BAG
    rig.run(1.0)
    assert rig.last.message.compensation == "none"
    assert bounds_hold(rig, BAG)
    assert rig.last.message.force[2] == pytest.approx(-20.0 - 0.8226 * 9.81 + 0.7, abs=0.5)
    assert rig.last.message.error_bound[2] > 8.0


def test_tare_then_load() -> None:
    rig = Rig()
    rig.run(0.5)
    answer = rig.tare()
    assert answer["ok"] is True
    assert answer["samples"] == pytest.approx(101, abs=1)
    assert np.array(answer["force"] + answer["torque"]) == pytest.approx(rig.sensor.exact(rig.rotation), abs=0.05)
    assert np.array(answer["std"]) == pytest.approx(rig.sensor.noise, rel=0.3)
    rig.external = BAG
    rig.settle(1.0)
    assert rig.last.message.compensation == "tare"
    assert rig.wrenches.mean(axis=0) == pytest.approx(BAG, abs=0.1)
    assert bounds_hold(rig, BAG)
    assert rig.last.message.error_bound[2] < 1.0


def test_identified_payload_holds_in_other_poses() -> None:
    rig = Rig()
    rig.run(0.2)
    answer = identified(rig)
    sigma = answer["sigma"]
    assert abs(answer["mass"] - rig.sensor.mass) < 4 * sigma[0]
    assert np.all(np.abs(np.array(answer["com"]) - rig.sensor.com) < 4 * np.array(sigma[1:4]))
    assert len(sigma) == 10 and len(answer["residual_rms"]) == 6 and answer["condition"] > 1
    rig.external = BAG
    for turn in ((1.0, 0.5, 2.0), (-0.7, 0.9, -1.0), (2.5, 0.0, 0.0)):
        rig.rotation = rotation_from_vector(turn)
        rig.settle(0.5)
        assert rig.last.message.compensation == "payload"
        assert bounds_hold(rig, BAG)
        assert rig.last.message.error_bound[:3].max() < 2.0


@pytest.mark.parametrize("duration", [0, -1, 31, "1", None, True, [1]])
def test_tare_of_a_bad_duration_is_refused(duration: object) -> None:
    rig = Rig()
    rig.run(0.1)
    rig.refuses(r"duration is .* wanted (0\.1 to 30 s|a number)", WRENCH_TARE, {"duration": duration})


def test_tare_is_refused_before_the_first_sample_and_while_turning() -> None:
    rig = Rig()
    rig.on = False
    rig.refuses("sensor/ft", WRENCH_TARE, {"duration": 1.0})
    rig.on = True
    rig.run(0.1)
    rig.turning = rotation_from_vector((0.001, 0.0, 0.0))
    rig.refuses("turned", WRENCH_TARE, {"duration": 1.0})
    assert rig.last.message.compensation == "none"


@pytest.mark.parametrize(("change", "words"), [({"stuck": [0]}, "stuck"), ({"on": False}, "sensor/ft")])
def test_tare_is_refused_when_the_sensor_fails_meanwhile(change: dict[str, object], words: str) -> None:
    rig = Rig()
    rig.run(0.5)
    rig.at(0.3, lambda: vars(rig).update(change))
    for _ in range(2):
        rig.refuses(words, WRENCH_TARE, {"duration": 1.0})


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        ({"action": "add"}, "no identification was started"),
        ({"action": "solve"}, "no identification was started"),
        ({"action": "dance"}, "wanted (one of start, add, solve, cancel|text)"),
        ({}, "wanted (one of start, add, solve, cancel|text)"),
        ({"action": ["start"]}, "wanted (one of start, add, solve, cancel|text)"),
    ],
)
def test_identification_refuses_what_makes_no_sense(request_: dict, reason: str) -> None:
    rig = Rig()
    rig.run(0.1)
    rig.refuses(reason, WRENCH_IDENTIFY, request_)


def test_identification_that_is_not_excited_keeps_its_poses_and_the_old_compensation() -> None:
    rig = Rig()
    rig.run(0.1)
    rig.identify("start")
    for heading in (0.0, 1.0, 2.0):
        rig.rotation = rotation_from_vector((0.0, 0.0, heading))
        rig.identify("add")
    rig.refuses("tilt", WRENCH_IDENTIFY, {"action": "solve"})
    rig.run(0.1)
    assert rig.last.message.compensation == "none"
    for rotation in TILTED[1:]:
        rig.rotation = rotation
        answer = rig.identify("add")
    assert answer["poses"] == 7
    assert rig.identify("solve")["mass"] == pytest.approx(0.8226, abs=0.05)


def test_cancelled_identification_is_forgotten() -> None:
    rig = Rig()
    rig.run(0.1)
    rig.identify("start")
    rig.identify("cancel")
    rig.refuses("no identification was started", WRENCH_IDENTIFY, {"action": "add"})


def test_silence_repeats_the_last_values_marked_invalid_at_20_hz() -> None:
    rig = Rig()
    rig.run(1.0)
    last = rig.last.message
    rig.on = False
    received = rig.heard(1.0)
    assert 19 <= len(received) <= 22
    for r in received[1:]:
        assert not r.header.valid and r.message.fault == "silent"
        assert r.message.force == pytest.approx(last.force, abs=1.0)
    first_invalid = next(r for r in received if not r.header.valid)
    assert first_invalid.arrival_ns - received[0].arrival_ns <= 40_000_000
    rig.on = True
    rig.run(0.2)
    assert rig.last.header.valid and rig.last.message.fault == ""


@pytest.mark.parametrize("axis", range(6))
def test_stuck_axis_is_invalid_within_a_tenth_of_a_second(axis: int) -> None:
    rig = Rig()
    rig.run(1.0)
    onset = rig.stack.scheduler.clock.now_ns()
    rig.stuck = [axis]
    received = rig.heard(0.3)
    first = next(r for r in received if not r.header.valid)
    assert first.message.fault == "stuck"
    assert first.arrival_ns - onset <= 100_000_000
    assert not received[-1].header.valid
    rig.stuck = []
    rig.run(0.3)
    assert rig.last.header.valid


def test_saturation_is_named_as_such_even_when_it_sticks() -> None:
    rig = Rig()
    rig.run(0.5)
    rig.saturated, rig.stuck = True, [2]
    received = rig.heard(0.5)
    assert {r.message.fault for r in received} == {"saturated"}
    assert not any(r.header.valid for r in received)


def test_sample_that_its_publisher_calls_invalid() -> None:
    rig = Rig()
    rig.run(0.5)
    rig.valid = False
    received = rig.heard(0.5)
    assert {(r.header.valid, r.message.fault) for r in received[1:]} == {(False, "invalid")}


def test_error_bound_follows_the_parameter() -> None:
    rig = Rig()
    rig.run(0.5)
    rig.tare()
    rig.run(0.1)
    before = rig.last.message.error_bound
    rig.ask(WRENCH_PARAMETERS, {"set": {"noise_bound": [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]}})
    rig.run(0.1)
    assert np.all(rig.last.message.error_bound[:3] > before[:3] + 0.4)


def test_a_sensor_that_drifts_as_declared_stays_within_its_growing_bound() -> None:
    # What a UR5e's users saw within five minutes of its start, in half a minute.
    drifted = np.array((0.3, 1.4, 4.0, 0.005, 0.01, -0.04))
    rig = Rig(zero_drift=list(2.0 * np.abs(drifted)))
    rig.run(0.2)
    rig.tare()
    rig.run(0.1)
    fresh, start, since = rig.last.message, rig.sensor.bias, rig.stack.now
    for _ in range(300):
        rig.sensor.bias = start + (rig.stack.now - since) / 30.0 * drifted
        rig.run(0.1)
        assert bounds_hold(rig, np.zeros(6))
    assert rig.last.message.zero_age == pytest.approx(fresh.zero_age + 30.0, abs=0.02)
    assert rig.last.message.error_bound[:3] - fresh.error_bound[:3] == pytest.approx([0.3, 1.4, 4.0], abs=0.01)


@pytest.mark.parametrize("told", [True, False])
def test_a_tare_on_level_ground_is_within_its_bound_on_a_ramp(told: bool) -> None:
    ramp = rotation_from_vector((0.06, np.radians(5.0), 0.0)) @ DOWN
    rig = Rig(floor_tilt=0.005 if told else 0.11)
    rig.run(0.2)
    rig.tare()
    rig.sensor.gravity = ramp
    rig.sensor.told = ramp if told else DOWN
    rig.rotation = rotation_from_vector((0.0, 0.0, 0.5))
    rig.settle(1.0)
    assert bounds_hold(rig, np.zeros(6))
    assert rig.wrenches.mean(axis=0)[:2] == pytest.approx(0.8226 * 9.81 * ramp[:2], abs=0.1), "the bound needs it"


def test_gravity_as_the_robot_tells_it_is_compensated_whatever_it_was_when_identified() -> None:
    rig = Rig()
    rig.sensor.gravity = rig.sensor.told = rotation_from_vector((0.2, -0.1, 0.0)) @ DOWN
    rig.run(0.2)
    identified(rig)
    rig.sensor.gravity = rig.sensor.told = rotation_from_vector((-0.15, 0.3, 0.0)) @ DOWN
    rig.rotation = rotation_from_vector((1.0, 0.5, 2.0))
    rig.settle(1.0)
    assert bounds_hold(rig, np.zeros(6))
    assert rig.wrenches.mean(axis=0) == pytest.approx(np.zeros(6), abs=0.1)


def test_low_pass_smooths() -> None:
    rough, smooth = Rig(), Rig(lowpass_hz=2.0)
    for rig in (rough, smooth):
        rig.run(1.0)
        rig.run(5.0)
    assert np.all(smooth.wrenches.std(axis=0) < 0.4 * rough.wrenches.std(axis=0))


@pytest.mark.parametrize("cutoff", [2.0, 10.0])
def test_a_ramp_comes_out_late_by_the_documented_lag(cutoff: float) -> None:
    lowpass, dt = LowPass(), 1e-3
    for n in range(3000):
        out = lowpass.filter(n * dt * np.ones(6), cutoff, dt)
    assert 3000 * dt - dt - out[0] == pytest.approx(1 / (2 * math.pi * cutoff), rel=0.05)


def test_off_passes_everything() -> None:
    lowpass = LowPass()
    lowpass.filter(np.zeros(6), 0.0, 0.01)
    assert lowpass.filter(np.ones(6), 0.0, 0.01) == pytest.approx(np.ones(6))


def test_first_value_after_a_reset_passes_unchanged() -> None:
    lowpass = LowPass()
    lowpass.filter(np.zeros(6), 1.0, 0.01)
    assert lowpass.filter(np.ones(6), 1.0, 0.01)[0] < 0.1
    lowpass.reset()
    assert lowpass.filter(np.ones(6), 1.0, 0.01) == pytest.approx(np.ones(6))
