"""The health check of a container: a service's own word, or that there is none."""

from __future__ import annotations

import pytest

from shared.loop.healthy import main
from tests.conftest import Router, StartProcess
from tests.support.ports import free_endpoint
from tests.support.wait import eventually

pytestmark = pytest.mark.processes


def test_without_a_router_nobody_is_healthy(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("TANDEM_CONNECT", free_endpoint())
    for name in ("router", "wrench"):
        assert main([name]) == 1
        assert "no router at" in capsys.readouterr().out


def test_a_service_is_healthy_once_it_is_fed(
    router: Router, start: StartProcess, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("TANDEM_CONNECT", router.endpoint)
    assert main(["router"]) == 0
    assert main(["wrench"]) == 1
    assert "wrench: nothing was heard of its health" in capsys.readouterr().out
    start("services.wrench", "--connect", router.endpoint)
    eventually(lambda: main(["wrench"]) == 1 and "sensor/ft: never" in capsys.readouterr().out, 30.0)
    start("services.mock", "--connect", router.endpoint)
    eventually(lambda: main(["wrench"]) == 0, 30.0, lambda: capsys.readouterr().out)
