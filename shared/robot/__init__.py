"""What every robot process needs, simulated or real: gate, numbers and description."""
