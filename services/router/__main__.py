"""``python -m services.router``."""

from shared.entry import enter

enter("services.router.main")
