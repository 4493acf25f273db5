"""The simulator as a process: what ``tests/promises`` and ``tests/contract`` do not say of every robot."""

from __future__ import annotations

import pytest

from shared.topics import SENSOR_CAMERA, SENSOR_FT
from shared.wire.client import Client
from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def test_images_are_rendered_elsewhere_and_only_for_those_who_look(shared_router: Router, start: StartProcess) -> None:
    client = Client(ZenohBus(connect=shared_router.endpoint))
    process = start("services.sim", "--connect", shared_router.endpoint, "--set", 'scene="carry"')
    eventually(lambda: "sim" in client.bus.living(), 20.0, "the simulator is alive")
    assert not client.bus.wanted(SENSOR_CAMERA.key)
    camera, ft = client.watch(SENSOR_CAMERA), client.watch(SENSOR_FT)
    eventually(lambda: camera.accepted >= 10, 30.0, "ten images")
    assert camera.rejected == 0 and camera.latest is not None
    assert len(camera.latest.message.data) > 5000
    assert ft.accepted > 3 * camera.accepted
    process.ends_in_time()
    client.bus.close()
