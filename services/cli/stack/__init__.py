"""A stack of processes: planned, started, looked after, stopped."""
