"""Health of a running stack: heard, judged and shown."""
