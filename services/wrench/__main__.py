"""``python -m services.wrench``."""

from shared.loop.entry import enter

enter("services.wrench.main")
