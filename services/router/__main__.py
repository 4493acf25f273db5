"""``python -m services.router``."""

from shared.loop.entry import enter

enter("services.router.main")
