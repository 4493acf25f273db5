"""``python -m services.task``."""

from shared.loop.entry import enter

enter("services.task.main")
