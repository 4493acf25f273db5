"""What every process of tandem shares."""
