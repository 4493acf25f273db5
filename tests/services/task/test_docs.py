"""docs/task.md names every state, fault and parameter."""

from __future__ import annotations

from services.task.faults import FAULTS
from services.task.parameters import TaskParameters
from services.task.states import State
from tests.support.processes import ROOT


def test_nothing_is_missing_in_the_documentation() -> None:
    text = (ROOT / "docs" / "task.md").read_text(encoding="utf-8")
    for name, (kind, sentence) in FAULTS.items():
        assert f"| `{name}` | {kind.value} | {sentence.replace('{}', '...')} |" in text
    for state in State:
        assert f"| {state.value} |" in text
    for name in TaskParameters.model_fields:
        assert f"| `{name}` |" in text
