"""A robot without physics: the template of a bridge, and what tests and benchmarks use for a robot."""
