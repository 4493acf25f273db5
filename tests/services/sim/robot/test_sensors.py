"""The sensors' errors and the faults put on them, as a subscriber sees them."""

from __future__ import annotations

import numpy as np
import pytest

from services.sim.robot.sensors import DITHER, ForceTorqueSensor
from shared import topics
from shared.parameters import Refused
from shared.robot.tiago import SENSOR_RANGE
from shared.spatial import rotation_matrix
from tests.services.sim.rig import Rig

QUIET = {"ft_noise": [0.0] * 6}


def test_noise_has_the_stated_deviation_and_bias() -> None:
    noise = np.array((0.1, 0.2, 0.3, 0.01, 0.02, 0.03))
    bias = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.3))
    sensor = ForceTorqueSensor(noise, bias, np.zeros(6), seed=3)
    readings = np.array([sensor.read(np.zeros(6), 0.0)[0] for _ in range(20_000)])
    assert readings.std(axis=0) == pytest.approx(noise, rel=0.03)
    assert readings.mean(axis=0) == pytest.approx(bias, abs=0.01)


def test_without_noise_it_repeats_no_value_all_the_same() -> None:
    sensor = ForceTorqueSensor(np.zeros(6), np.zeros(6), np.zeros(6), seed=0)
    readings = np.array([sensor.read(np.ones(6), 0.0)[0] for _ in range(1000)])
    assert (np.abs(np.diff(readings, axis=0)) > 0.0).all()
    assert readings.std(axis=0) == pytest.approx(DITHER, rel=0.2)


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_beyond_its_range_an_axis_saturates_and_says_so(axis: int, sign: float) -> None:
    sensor = ForceTorqueSensor(np.zeros(6), np.zeros(6), np.zeros(6), seed=0)
    wrench = np.zeros(6)
    wrench[axis] = sign * 1.1 * SENSOR_RANGE[axis]
    reading, saturated = sensor.read(wrench, 0.0)
    assert saturated
    assert reading[axis] == sign * SENSOR_RANGE[axis]
    assert not sensor.read(0.8 * wrench, 0.0)[1]


def test_its_bias_drifts_by_the_minute() -> None:
    drift = np.array((0.3, -1.4, 4.0, 0.01, -0.02, 0.03))
    sensor = ForceTorqueSensor(np.zeros(6), np.ones(6), drift, seed=0)
    assert sensor.read(np.zeros(6), 150.0)[0] == pytest.approx(1.0 + 2.5 * drift, abs=1e-4)


@pytest.mark.parametrize("tells", [True, False])
def test_on_a_ramp_gravity_turns_with_the_base_and_is_told_if_the_robot_can(tells: bool) -> None:
    settings = {**QUIET, "ft_drift": [0.0] * 6, "tells_gravity": tells}
    rig = Rig(floor_slope=[0.1, -0.05], **settings)
    rig.run(0.2)
    down = np.array((-np.sin(0.1), np.sin(0.05), 0.0))
    down[2] = -np.sqrt(1.0 - down @ down)
    sample = rig.last(topics.SENSOR_FT)
    felt = rotation_matrix(sample.orientation) @ sample.force
    assert felt == pytest.approx(0.8226 * 9.81 * down, abs=0.01)
    assert sample.gravity == pytest.approx(down if tells else (0.0, 0.0, -1.0), abs=1e-9)


def test_there_is_no_panel_on_a_ramp() -> None:
    with pytest.raises(Refused, match="floor_slope"):
        Rig(floor_slope=[0.1, 0.0], scene="full")


def test_the_same_seed_gives_the_same_run_and_another_seed_another_one() -> None:
    def readings(seed: int) -> np.ndarray:
        rig = Rig(seed=seed)
        rig.ask(command="load", mass=1.0)
        rig.move((0.02, 0, -0.05), 0.5)
        return np.array([np.concatenate((m.force, m.torque)) for m in rig.all(topics.SENSOR_FT)])

    first = readings(1)
    assert (first == readings(1)).all()
    assert (first != readings(2)).any()


def test_off_is_silence_and_only_of_that_sensor() -> None:
    rig = Rig()
    for target, keys in (("ft", ("sensor/ft",)), ("joints", ("state/joints", "state/ee"))):
        rig.ask(command="fault", target=target, kind="off")
        before = {key: len(received) for key, received in rig.received.items()}
        rig.run(0.5)
        silent = {key for key in ("sensor/ft", "state/joints", "state/ee") if len(rig.received[key]) == before[key]}
        assert silent == set(keys)
        rig.ask(command="fault", target=target, kind="ok")
        rig.run(0.2)
        assert all(len(rig.received[key]) > before[key] for key in keys)


def test_stuck_encoders_repeat_one_position() -> None:
    rig = Rig()
    rig.ask(command="fault", target="joints", kind="stuck")
    rig.run(0.02)
    height = rig.height
    rig.move((0, 0, -0.1), 0.5)
    assert rig.height == height
    rig.ask(command="fault", target="joints", kind="ok")
    rig.run(0.05)
    assert rig.height < height - 0.03


def test_bias_shifts_every_axis_or_each_by_its_own() -> None:
    rig = Rig(**QUIET)
    before = rig.last(topics.SENSOR_FT)
    rig.ask(command="fault", target="ft", kind="bias", value=[1, 2, 3, 0.1, 0.2, 0.3])
    rig.run(0.1)
    after = rig.last(topics.SENSOR_FT)
    assert after.force - before.force == pytest.approx((1, 2, 3), abs=1e-3)
    assert after.torque - before.torque == pytest.approx((0.1, 0.2, 0.3), abs=1e-3)
    rig.ask(command="fault", target="ft", kind="bias", value=5.0)
    rig.run(0.1)
    assert rig.last(topics.SENSOR_FT).force - before.force == pytest.approx((5, 5, 5), abs=1e-3)


def test_delay_brings_old_samples_whose_stamps_say_so() -> None:
    rig = Rig(**QUIET)
    subscription = rig.stack.client.watch(topics.SENSOR_FT)
    rig.run(0.2)
    rig.ask(command="fault", target="ft", kind="delay", value=0.05)
    rig.ask(command="push", force=[0.0, 0.0, -10.0], duration=10.0)
    rig.run(0.04)
    arrived = subscription.accepted
    assert arrived == 20
    rig.run(0.2)
    assert subscription.latest is not None
    assert subscription.latest.delay == pytest.approx(0.05, abs=1e-3)
    pushed = [np.linalg.norm(message.force) > 10.0 for message in rig.all(topics.SENSOR_FT)]
    assert sum(pushed) == pytest.approx(19, abs=1)
    assert pushed[-1] and not pushed[arrived - 1]


def test_faults_show_in_the_health() -> None:
    rig = Rig()
    rig.ask(command="fault", target="ft", kind="stuck")
    rig.run(1.0)
    health = rig.received["health/sim"][-1].message
    assert health.state == "degraded"
    assert "ft sensor: stuck" in health.detail
