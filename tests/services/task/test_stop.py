"""Who may stop the task, and who may release the stop."""

from __future__ import annotations

import pytest

from shared.messages import Stop
from shared.parameters import Refused
from shared.topics import STOP
from tests.services.task.rig import Rig


def test_an_invalid_stop_stops_but_an_invalid_release_releases_nothing() -> None:
    rig = Rig().carrying()
    rig.stack.client.publish(STOP, Stop(True, "hand in the way"), valid=False)
    rig.until("holding", 0.1)
    rig.stack.client.publish(STOP, Stop(False), valid=False)
    rig.run(0.5)
    with pytest.raises(Refused, match="hand in the way"):
        rig.ask("start")
    rig.stack.client.publish(STOP, Stop(False))
    rig.run(0.1)
    assert rig.ask("start") == "carrying"
