"""``python -m services.recorder``."""

from shared.loop.entry import enter

enter("services.recorder.main")
