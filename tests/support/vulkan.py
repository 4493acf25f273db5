"""Whether pictures can be taken of the view: a driver of Vulkan, that of the processor at least."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

_DRIVERS = ("/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d")


def wanted() -> None:
    """Skips the test where there is none; with TANDEM_VULKAN=required, as in .ci/run, it fails instead."""
    if not any(Path(folder).glob("*.json") for folder in _DRIVERS):
        why = "no driver of Vulkan: apt-get install mesa-vulkan-drivers"
        (pytest.fail if os.environ.get("TANDEM_VULKAN") == "required" else pytest.skip)(why)
