"""What surrounds the simulated robot: panel, bag, person."""
