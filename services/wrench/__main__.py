"""``python -m services.wrench``."""

from shared.entry import enter

enter("services.wrench.main")
