"""``python -m services.sim``."""

from shared.loop.entry import enter

enter("services.sim.main")
