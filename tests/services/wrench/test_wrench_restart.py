"""What the service keeps of a tare and a payload when it or the robot is started again."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.services.wrench.rig import BAG, Rig, bounds_hold, identified
from tests.services.wrench.sensor import TILTED


def test_restarted_process_goes_on_with_the_tare_of_the_same_robot_run(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    rig.tare()
    rig.external = BAG
    rig.settle(0.5)
    before = rig.wrenches.mean(axis=0)
    again = Rig(tmp_path)
    again.surroundings.publisher.session = rig.surroundings.publisher.session
    again.external = BAG
    again.run(0.5)
    assert again.last.message.compensation == "tare"
    assert again.wrenches.mean(axis=0) == pytest.approx(before, abs=0.1)


def test_tare_of_another_robot_run_is_not_used(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.run(0.2)
    rig.tare()
    again = Rig(tmp_path)
    again.run(0.5)
    assert again.last.message.compensation == "none"


def test_tare_survives_a_restart_of_the_robot_process() -> None:
    rig = Rig()
    rig.run(0.2)
    rig.tare()
    rig.on = False
    rig.run(2.0)
    rig.new_session()
    rig.on = True
    rig.run(0.5)
    assert rig.last.header.valid and rig.last.message.compensation == "tare"


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
