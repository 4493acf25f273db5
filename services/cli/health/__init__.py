"""What is seen of a running stack, and what is wrong with it."""
