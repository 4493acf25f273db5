"""Fixture of the tests with a ROS 1."""

from __future__ import annotations

import pytest

from tests.support.ros1 import ros

ros = pytest.fixture(ros)
