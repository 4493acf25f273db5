"""The control laws, and the quadratic program that they share."""
