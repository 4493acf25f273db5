"""The published reference is the table."""

from pathlib import Path

from shared.reference import lines

REFERENCE = Path(__file__).parents[2] / "docs" / "contract.md"


def test_reference_is_up_to_date():
    assert REFERENCE.read_text(encoding="utf-8") == "\n".join(lines()) + "\n", (
        "run: python -m shared.reference > docs/contract.md"
    )
