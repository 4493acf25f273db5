"""What the service keeps of a tare and a payload when it or the robot is started again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from services.wrench.error_bound import NO_ZERO
from services.wrench.zero import Zero
from shared.service import LONGEST_DT
from shared.spatial import Array
from shared.topics import WRENCH_IDENTIFY, WRENCH_PARAMETERS
from tests.services.wrench.rig import BAG, Rig, bounds_hold, identified
from tests.services.wrench.sensor import TILTED


def process_restarted(rig: Rig, folder: Path, away: float) -> Rig:
    """Another wrench process, ``away`` [s] after the first one ended, with the same run of the robot."""
    again = Rig(folder)
    again.surroundings.publisher.session = rig.surroundings.publisher.session
    again.on = False
    again.run(rig.stack.now + away)
    again.on = True
    return again


def test_restarted_process_goes_on_with_the_tare_of_the_same_robot_run_and_its_age(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    rig.tare()
    rig.external = BAG
    rig.settle(0.5)
    before, age = rig.wrenches.mean(axis=0), rig.last.message.zero_age
    assert age == pytest.approx(1.52, abs=0.05)
    again = process_restarted(rig, tmp_path, away=60.0)
    again.external = BAG
    again.run(0.5)
    assert again.last.message.compensation == "tare"
    assert again.wrenches.mean(axis=0) == pytest.approx(before, abs=0.1)
    assert again.last.message.zero_age == pytest.approx(age + 60.5, abs=0.05)
    assert np.all(again.last.message.error_bound > rig.last.message.error_bound)


def test_zero_from_the_future_is_not_used(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(20.0)
    rig.tare()
    again = process_restarted(rig, tmp_path, away=-10.0)
    again.run(0.5)
    assert (again.last.message.compensation, again.last.message.zero_age) == ("none", -1.0)


def test_tare_of_another_robot_run_is_not_used(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    rig.tare()
    again = Rig(tmp_path)
    again.run(0.5)
    assert again.last.message.compensation == "none"


def robot_restarted(rig: Rig, silence: float = 2.0) -> Rig:
    """Another run of the robot process, whose clock reads something else, with a sensor that has lost its zero."""
    rig.on = False
    rig.run(silence)
    rig.new_session()
    rig.sensor.bias = rig.sensor.bias + np.array((1.0, 4.0, -2.0, 0.1, -0.3, 0.2))
    rig.on = True
    rig.run(0.5)
    return rig


def test_a_tare_ends_with_the_run_of_the_robot_process() -> None:
    rig = Rig()
    rig.run(0.2)
    rig.tare()
    robot_restarted(rig)
    newest = rig.last.message
    assert rig.last.header.valid and (newest.compensation, newest.zero_age) == ("none", -1.0)
    assert bounds_hold(rig, np.zeros(6))


def test_an_identified_weight_outlasts_the_run_of_the_robot_process_and_its_zero_does_not() -> None:
    rig = Rig()
    rig.run(0.2)
    identified(rig)
    rig.run(0.2)
    assert rig.last.message.zero_age == pytest.approx(5.45, abs=0.1), "as old as the first of five poses"
    robot_restarted(rig)
    assert (rig.last.message.compensation, rig.last.message.zero_age) == ("payload", -1.0)
    assert bounds_hold(rig, np.zeros(6)) and rig.last.message.error_bound[0] > 5.0
    assert rig.tare()["replaced_age"] == -1.0
    rig.run(0.5)
    assert bounds_hold(rig, np.zeros(6)) and rig.last.message.error_bound[0] < 1.0
    assert rig.tare()["replaced_age"] == pytest.approx(2.5, abs=0.1)


@pytest.mark.parametrize("seen", [True, False])
def test_an_identified_weight_outlasts_a_restart_of_robot_and_service_and_the_zero_does_not(
    tmp_path: Path, seen: bool
) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    identified(rig)
    if seen:  # the service hears the new run before it ends
        robot_restarted(rig)
    for _ in range(2):
        again = Rig(tmp_path)
        if seen:
            again.surroundings.publisher.session = rig.surroundings.publisher.session
        again.sensor.bias = again.sensor.bias + np.array((1.0, 4.0, -2.0, 0.1, -0.3, 0.2))
        again.rotation, again.external = TILTED[3], BAG
        again.run(0.5)
        assert (again.last.message.compensation, again.last.message.zero_age) == ("payload", -1.0)
        assert bounds_hold(again, BAG) and again.last.message.error_bound[0] > 5.0


def test_a_payload_that_was_given_up_does_not_come_back(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    file = identified(rig)["file"]
    rig.ask(WRENCH_PARAMETERS, {"set": {"payload": file}})
    rig.ask(WRENCH_PARAMETERS, {"set": {"payload": ""}})
    rig.run(0.2)
    again = Rig(tmp_path)
    again.run(0.5)
    assert again.last.message.compensation == "none"


def test_poses_of_two_runs_are_not_mixed() -> None:
    rig = Rig()
    rig.run(0.2)
    rig.identify("start")
    rig.identify("add")
    robot_restarted(rig)
    rig.refuses("no identification was started", WRENCH_IDENTIFY, {"action": "add"})


@pytest.mark.parametrize("silence", [0.05, 30.0])
def test_a_zero_that_is_declared_to_survive_goes_on_ageing(silence: float) -> None:
    rig = Rig(zero_survives_restart=True)
    rig.run(0.2)
    rig.tare()
    rig.on = False
    rig.run(silence)
    rig.new_session()
    rig.on = True
    rig.run(0.5)
    assert rig.last.message.compensation == "tare"
    assert rig.last.message.zero_age == pytest.approx(1.5 + silence, abs=0.1)
    assert bounds_hold(rig, np.zeros(6))


def test_how_long_a_restart_took_has_to_be_known_for_a_zero_to_survive_it() -> None:
    zero = Zero()
    zero.sampled(10**9)
    zero.since = 0
    zero.silent(LONGEST_DT)
    zero.restarted(-(10**12), 0.01, survives=True)
    assert zero.age == NO_ZERO


@pytest.fixture(scope="module")
def last_weeks_file(tmp_path_factory: pytest.TempPathFactory) -> str:
    rig = Rig(tmp_path_factory.mktemp("last week"))
    rig.run(0.2)
    return identified(rig)["file"]


@settings(max_examples=20)
@given(off=st.tuples(*[st.floats(-1.0, 1.0)] * 6), turn=st.sampled_from(TILTED))
def test_samples_with_last_weeks_file_are_within_their_bounds(last_weeks_file: str, off: tuple, turn: Array) -> None:
    rig = Rig(payload=last_weeks_file)
    rig.sensor.bias = rig.sensor.bias + np.multiply(off, (4.0, 4.0, 4.0, 0.4, 0.4, 0.4))
    rig.rotation, rig.external = turn, BAG
    rig.run(0.3)
    assert rig.last.message.zero_age == -1.0
    assert bounds_hold(rig, BAG)


def test_identified_payload_is_saved_and_read_at_the_next_start(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    answer = identified(rig)
    again = Rig(payload=answer["file"])
    again.external = BAG
    again.rotation = TILTED[3]
    again.run(0.5)
    assert again.last.message.compensation == "payload"
    assert bounds_hold(again, BAG)


def test_full_disk_is_noted_and_changes_nothing_else(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    rig = Rig(blocked)
    rig.run(0.2)
    assert rig.tare()["ok"] is True
    rig.run(0.2)
    assert rig.last.header.valid and rig.last.message.compensation == "tare"
    assert "cannot write" in rig.wrench.notes()
