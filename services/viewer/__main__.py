"""``python -m services.viewer``."""

from shared.loop.entry import enter

enter("services.viewer.main")
