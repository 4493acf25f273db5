"""What experiments measure and claim alike."""
