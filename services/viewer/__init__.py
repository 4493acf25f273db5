"""Draws what the robot does, and why, in a browser."""
