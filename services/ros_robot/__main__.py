"""``python -m services.ros_robot``."""

from shared.loop.entry import enter

enter("services.ros_robot.main")
