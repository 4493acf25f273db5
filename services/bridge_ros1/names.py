"""rospy's classes by the names that profiles have for them."""

from __future__ import annotations

import importlib
from typing import Any

from shared.parameters import Refused
from shared.robot.profile import Profile


def message_class(kind: str) -> Any:
    """The class of a type such as ``sensor_msgs/JointState``.

    Raises:
        Refused: there is none.
    """
    package, _, name = kind.partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError):
        raise Refused(f"there is no ROS 1 message {kind} here; Debian's package is python3-{package}") from None


def heard(profile: Profile) -> dict[str, str]:
    """Topics that the robot publishes, with their types; a topic of compressed images is told by its name."""
    kinds = profile.heard()
    if profile.camera and profile.camera.image.endswith("/compressed"):
        kinds[profile.camera.image] = "sensor_msgs/CompressedImage"
    return kinds
