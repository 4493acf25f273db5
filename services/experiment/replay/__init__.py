"""Recorded inputs, given to one service again: whether it answers alike, and what it would have answered otherwise."""
