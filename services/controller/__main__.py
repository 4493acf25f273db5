"""``python -m services.controller``."""

from shared.entry import enter

enter("services.controller.main")
