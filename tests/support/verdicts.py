"""What an experiment that was played through real middleware says at its end."""

from __future__ import annotations

PASSED, FAILED, NOT_JUDGED = 0, 1, 4
"""Exit statuses of an experiment and of its report."""
_OF_THE_WAY = "carries it steadily"
"""How far a load swings depends on how long messages are under way, on a test's machine longer than is declared; in
simulated time it is judged (test_load_through_bridge.py)."""


def failed(output: str) -> list[str]:
    """The claims that failed, of those that hold on whatever machine."""
    return [line for line in output.splitlines() if line.startswith("FAIL") and _OF_THE_WAY not in line]
