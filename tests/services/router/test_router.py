"""The router as users start it: what it alone keeps. What all processes keep is in ``tests/promises``."""

from __future__ import annotations

from pathlib import Path

import pytest

from shared.wire.zenoh import ZenohBus
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint, free_port

pytestmark = pytest.mark.processes


def test_taken_port_is_one_line_that_names_port_and_remedy(router: Router, start: StartProcess) -> None:
    second = start("services.router", "--listen", router.endpoint)
    other = router.endpoint.rsplit(":", 1)[0] + ":" + str(int(router.endpoint.rsplit(":", 1)[1]) + 1)
    second.refuses(router.endpoint, "taken", f"--listen {other}", f"--connect {other}")
    assert router.process.running


def test_configuration_file_decides(start: StartProcess, tmp_path: Path) -> None:
    endpoint, path = free_endpoint(), tmp_path / "router.json5"
    path.write_text(f'{{ mode: "router", listen: {{ endpoints: ["{endpoint}"] }}, '
                    "scouting: { multicast: { enabled: false } } }")  # fmt: skip
    process = start("services.router", "--config", str(path))
    process.wait_for_output("listening")
    ZenohBus(connect=endpoint).close()


def test_listens_on_loopback_only_unless_told_otherwise(start: StartProcess) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    process = start("services.router", environment={"TANDEM_LISTEN": endpoint})
    process.wait_for_output(endpoint)
    port = f"{int(endpoint.rsplit(':', 1)[1]):04X}"
    table = Path(f"/proc/{process.pid}/net/tcp").read_text().splitlines()[1:]
    listening = {fields[1] for fields in map(str.split, table) if fields[3] == "0A"}
    assert [address for address in listening if address.endswith(f":{port}")] == [f"0100007F:{port}"]
