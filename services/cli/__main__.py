"""The way into the command `tandem`, and `python -m services.cli`: what it lacks is said in one line."""

import sys
import traceback

from shared.loop.entry import missing
from shared.processes import PROCESSES


def main() -> None:
    """Runs the command that was given; ends with status 2 if a package that it needs is not installed."""
    try:
        from services.cli.main import app

        app()
    except ModuleNotFoundError as problem:
        print(f"tandem: {missing(_needing(problem), problem)}", file=sys.stderr)
        sys.exit(2)


def _needing(problem: ModuleNotFoundError) -> str:
    """The process whose module needs the package: a replay works with the services' own."""
    modules = (frame.f_globals["__name__"].split(".") for frame, _ in traceback.walk_tb(problem.__traceback__))
    found = [parts[1] for parts in modules if parts[0] == "services" and len(parts) > 1]
    known = {process.name for process in PROCESSES}
    return next((name for name in reversed(found) if name in known), "cli")


if __name__ == "__main__":
    main()
