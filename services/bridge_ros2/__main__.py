"""``python -m services.bridge_ros2``."""

from shared.loop.entry import enter

enter("services.bridge_ros2.main")
