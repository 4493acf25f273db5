"""A loop that works already, in a stack or with steps that take time, and a subscription that a test feeds."""

from __future__ import annotations

import pytest

from tests.shared.loop.rig import BusyLoop, Rig
from tests.shared.rig import Feed


@pytest.fixture
def rig() -> Rig:
    return Rig().working()


@pytest.fixture
def loop() -> BusyLoop:
    return BusyLoop().working()


@pytest.fixture
def feed() -> Feed:
    return Feed()
