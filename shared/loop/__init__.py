"""A service as a process: the loop, its health, its configuration."""
