"""``python -m services.bridge_ros1``."""

from shared.loop.entry import enter

enter("services.bridge_ros1.main")
