"""Over a real router, where a recording hears what a service takes at other moments, or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from services.experiment.replay.equality import equality, told
from services.experiment.replay.recorded import read
from services.experiment.replay.replay import replay
from shared.topics import WRENCH_TARE, setup_topic
from shared.wire.bus import NoReply
from shared.wire.client import Client
from shared.wire.log import recordings
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def test_live_answers_are_equal_to_the_last_bit_as_long_as_all_that_was_taken_was_heard(
    router: Router, start: StartProcess, tmp_path: Path
) -> None:
    place = tmp_path / "record"
    recorder = start("services.recorder", "--connect", router.endpoint, "--out", str(place))
    recorder.wait_for_output("recording")
    for service in ("wrench", "mock"):
        start(f"services.{service}", "--connect", router.endpoint)
    bus = ZenohBus(connect=router.endpoint)
    client = Client(bus)
    setups = client.watch(setup_topic("wrench"))

    def tared() -> bool:
        try:
            return client.ask(WRENCH_TARE, {"duration": 0.3, "force": True})["samples"] > 0
        except (NoReply, ValueError):
            return False

    eventually(tared, 30.0, "a tare is granted")
    heard = setups.accepted
    eventually(lambda: setups.accepted >= heard + 3, 30.0, "three more words on what was taken")
    bus.close()
    recorder.ends_in_time()
    (paths,) = recordings(place)
    found = read(paths, "wrench")
    (life,) = found.lives
    compared = equality(life, replay(found, life, {}))
    assert compared.compared > 100
    # The network may drop a message for the recorder alone, and nothing is known of it then.
    unknown = compared.missing or compared.gaps
    assert unknown or compared.equal == compared.compared, told("wrench", compared)
