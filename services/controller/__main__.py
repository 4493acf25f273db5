"""``python -m services.controller``."""

from shared.loop.entry import enter

enter("services.controller.main")
