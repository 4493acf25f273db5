"""``python -m services.task``."""

from shared.entry import enter

enter("services.task.main")
