"""Figures of another revision and of this tree, measured in turns: ``python -m benchmarks.against REV PROGRAM.py``.

No machine is equally busy for long, so only what was measured in turns can be compared. A turn runs the program once
in each tree, each time as a process of its own; who is first changes with every turn.

The program imports what it measures from the tree that it is run in, and prints one JSON map from names to figures;
smaller is better. As it is the same for both trees, it may use only what both have, or look for it in both places.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.support.processes import ROOT
from tests.support.revision import worktree

TURNS = 10
_PLACE = "from pathlib import Path; import shared; print(Path(next(iter(shared.__path__))).resolve().parent)"


@dataclass
class Figure:
    """One figure of both trees, in the order of the turns."""

    before: list[float] = field(default_factory=list)
    here: list[float] = field(default_factory=list)

    @property
    def medians(self) -> float:
        """Ratio of the medians, this tree over the other."""
        return statistics.median(self.here) / statistics.median(self.before)

    @property
    def least(self) -> float:
        """Ratio of the smallest ones: what remains if the rest of the machine rests."""
        return min(self.here) / min(self.before)

    @property
    def turns(self) -> list[float]:
        """Ratio of each turn."""
        return [here / before for here, before in zip(self.here, self.before, strict=True)]


def compare(revision: str, program: str, turns: int = TURNS) -> dict[str, Figure]:
    """Measure by name what a program prints.

    Args:
        revision: of git, such as HEAD.
        program: source text, see above.
        turns: how often each tree is measured.

    Raises:
        SystemExit: if a program fails, or imports the sources of another tree.
    """
    found: dict[str, Figure] = {}
    with worktree(revision) as folder:
        for tree in (folder, ROOT):
            # An installed copy of the sources, imported by mistake, would be compared with itself.
            if (place := _run(tree, _PLACE).strip()) != str(tree):
                raise SystemExit(f"a program in {tree} imports the sources in {place}")
        for turn in range(turns):
            for tree in (folder, ROOT) if turn % 2 == 0 else (ROOT, folder):
                for name, value in json.loads(_run(tree, program)).items():
                    figure = found.setdefault(name, Figure())
                    (figure.here if tree is ROOT else figure.before).append(value)
            print(f"turn {turn + 1} of {turns}", file=sys.stderr, flush=True)
    return found


def show(found: dict[str, Figure]) -> None:
    """Print a line per figure: medians, and the ratios of medians, of the smallest, and of the turns' middle half."""
    width = max(map(len, found), default=0)
    print(f"{'':<{width}}  {'before':>9} {'here':>9}   ratio of medians   of the least   turns, middle half")
    for name, figure in found.items():
        before, here = statistics.median(figure.before), statistics.median(figure.here)
        low, _, high = statistics.quantiles(figure.turns, n=4) if len(figure.turns) > 1 else figure.turns * 3
        print(
            f"{name:<{width}}  {before:>9.4g} {here:>9.4g}   {figure.medians:>16.3f}   {figure.least:>12.3f}   "
            f"{low:.3f} to {high:.3f}"
        )


def _run(tree: Path, program: str) -> str:
    # Without a file the first place where Python looks for modules is the current folder: the tree's.
    done = subprocess.run([sys.executable, "-c", program], cwd=tree, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(f"the program in {tree} failed with exit status {done.returncode}")
    return done.stdout


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.against", description=__doc__)
    parser.add_argument("revision", metavar="REV", help="of git, such as HEAD")
    parser.add_argument("program", metavar="PROGRAM.py", type=Path)
    parser.add_argument("--turns", type=int, default=TURNS, help="how often each is measured (default %(default)s)")
    given = parser.parse_args(arguments)
    show(compare(given.revision, given.program.read_text(), given.turns))


if __name__ == "__main__":
    main()
