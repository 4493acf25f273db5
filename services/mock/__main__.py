"""``python -m services.mock``."""

from shared.loop.entry import enter

enter("services.mock.main")
