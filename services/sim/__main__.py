"""``python -m services.sim``."""

from shared.entry import enter

enter("services.sim.main")
