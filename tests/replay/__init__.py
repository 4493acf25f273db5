"""Golden recordings: what wrench, controller, base and task took and answered, replayed as `tandem replay` does it."""
