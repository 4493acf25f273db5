"""``python -m services.experiment``."""

from shared.entry import enter

enter("services.experiment.main")
