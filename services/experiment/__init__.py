"""Plays an experiment against running processes, judges it and writes a report."""
