"""``python -m services.base``."""

from shared.loop.entry import enter

enter("services.base.main")
