"""The published reference is the table."""

from pathlib import Path

import pytest

from shared.reference import lines

REFERENCE = Path(__file__).parents[2] / "docs" / "contract.md"


def test_reference_is_up_to_date():
    assert REFERENCE.read_text(encoding="utf-8") == "\n".join(lines()) + "\n", (
        "run: python -m shared.reference > docs/contract.md"
    )


@pytest.mark.parametrize(
    "line",
    [
        "- `ttl` float: s, > 0, at most 0.2: a longer one counts as that, 0.05 if absent",
        "- `ttl` float: s, > 0, at most 0.2: a longer one counts as that, 0.1 if absent",
        "- `force_limit` float[3]: N, > 0",
        "- `nominal_force` float[3]: N, [0, 0, 0] if absent",
        "- `opening` float: m, >= 0",
        "- `reason` text: the first 200 characters count, empty if absent",
    ],
)
def test_it_says_what_is_allowed_and_what_holds_if_nothing_is_said(line: str) -> None:
    assert line in list(lines())
