"""Whether a process works, by its own newest word: `python -I -S shared/loop/healthy.py`, for health checks.

The word is in the file that TANDEM_HEALTH names for both, the process and who asks. The exit status is 0 if it works;
else 1, and one line says why. Several containers are asked every few seconds on the cores that control: nothing is
imported but the standard library, and no session is opened.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time

FRESH = 3.0
"""A word that is older [s] is none: whoever said it hangs. Six times the period of health."""


def tell(state: str, detail: str = "") -> None:
    """Leave a word on how this process is, in place of the last one; a reader finds either, and never half of one.

    Without TANDEM_HEALTH it does nothing. Where it cannot write, the process goes on, and whoever asks hears nothing.

    Args:
        state: "ok", or what else it is.
        detail: why.
    """
    if not (file := os.environ.get("TANDEM_HEALTH")):
        return
    with contextlib.suppress(OSError):
        with open(file + ".new", "w", encoding="utf-8") as new:
            new.write(f"{time.monotonic()} {state} {detail}")
        os.replace(file + ".new", file)


def trouble() -> str:
    """Why the process does not work, in its own words; empty if it does."""
    try:
        with open(os.environ["TANDEM_HEALTH"], encoding="utf-8") as word:
            said, state, detail = word.read().split(" ", 2)
    except FileNotFoundError:
        return "it has not said yet how it is"
    silent = time.monotonic() - float(said)
    if silent > FRESH:
        return f"it has said nothing for {silent:.1f} s"
    return "" if state == "ok" else f"{state}: {detail}"


def main() -> int:
    """Asks."""
    wrong = trouble()
    if wrong:
        print(wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
