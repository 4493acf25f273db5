"""rospy as Debian packages it, which the Python environment of tandem does not see by itself."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path

from shared.parameters import Refused

DIST_PACKAGES = Path("/usr/lib/python3/dist-packages")
"""Where Debian's Python packages are."""
NEEDED = {
    "rospy": "python3-rospy",
    "std_msgs": "python3-std-msgs",
    "geometry_msgs": "python3-geometry-msgs",
    "sensor_msgs": "python3-sensor-msgs",
    "trajectory_msgs": "python3-trajectory-msgs",
    "nav_msgs": "python3-nav-msgs",
}
"""Modules, and the packages of Debian that have them."""


MASTER = {"rosmaster": "python3-rosmaster"}
"""The same, for whoever is the ROS master itself."""


def find_rospy(needed: Mapping[str, str] = NEEDED) -> None:
    """Have ``import rospy`` find a ROS that was sourced, or Debian's packages, after everything that is here already.

    Args:
        needed: modules, and the packages that have them.

    Raises:
        Refused: a module is nowhere; the text says how to install it.
    """
    if _missing(needed) and str(DIST_PACKAGES) not in sys.path:
        sys.path.append(str(DIST_PACKAGES))
    if missing := _missing(needed):
        raise Refused(
            f"a robot under ROS 1 needs rospy, and {', '.join(missing)} cannot be imported: on Debian 12 "
            f"`apt-get install {' '.join(missing.values())}`, elsewhere source ROS noetic, or use the image "
            "tandem-bridge_ros1"
        )


def _missing(needed: Mapping[str, str]) -> dict[str, str]:
    return {module: package for module, package in needed.items() if importlib.util.find_spec(module) is None}
