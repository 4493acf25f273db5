"""Recorded inputs, replayed: what wrench, controller, base and task answer to them today, pinned to the last bit."""
