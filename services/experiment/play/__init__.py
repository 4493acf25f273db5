"""Playing and recording an experiment."""
