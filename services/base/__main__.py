"""``python -m services.base``."""

from shared.entry import enter

enter("services.base.main")
