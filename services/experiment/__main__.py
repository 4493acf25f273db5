"""``python -m services.experiment``."""

from shared.loop.entry import enter

enter("services.experiment.main")
