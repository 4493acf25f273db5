"""`tandem keys`: an authority of one's own, and a certificate for each process of a robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from services.cli.authority import LONGEST, Authority, Wanted, end_of
from services.cli.common import DEFAULT_ROBOT, Robot, refuse
from shared.processes import ROUTER, publisher_named
from shared.wire.access import PARTICIPANTS, common_name

_OWN_ADDRESSES = ("localhost", "127.0.0.1", "::1")


def keys(
    folder: Annotated[Path, typer.Argument(help="Where they go: authority/ and a folder for each process.")],
    only: Annotated[
        list[str] | None, typer.Option(envvar="TANDEM_KEYS", help="Only of these processes; of all if left out.")
    ] = None,
    days: Annotated[float, typer.Option(min=0.0, max=LONGEST, help="How long a certificate is valid [days].")] = 365.0,
    name: Annotated[
        list[str] | None, typer.Option(envvar="TANDEM_NAMES", help="Further host name or address of every process.")
    ] = None,
    renew: Annotated[bool, typer.Option("--renew", help="Make even those anew that will do for long.")] = False,
    revoke: Annotated[bool, typer.Option("--revoke", help="Make the authority anew: older ones are refused.")] = False,
    into: Annotated[
        Path | None, typer.Option(help="Put what --only names into this folder, for whoever takes it elsewhere.")
    ] = None,
    robot: Robot = DEFAULT_ROBOT,
) -> None:
    """Make certificates for a closed network; who has a folder of them can be started with `--secure FOLDER/NAME`.

    Those that are there are kept, unless less than a third of --days is left or something is wrong with them.
    """
    known = (ROUTER.name, *PARTICIPANTS)
    for participant in only or ():
        if participant not in known:
            refuse(f"--only {participant}: choose from {', '.join(known)}")
    places = {participant: folder / participant for participant in only or known}
    if into is not None:
        if len(places) > 1:
            refuse(f"--into {into}: wanted one --only, got {', '.join(places)}")
        places = dict.fromkeys(places, into)
    made: list[str] = []
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        authority = Authority(folder / "authority", anew=revoke)
        for participant, place in places.items():
            addresses = (participant, publisher_named(participant), *_OWN_ADDRESSES, *(name or ()))
            wanted = Wanted(common_name(robot, participant), tuple(dict.fromkeys(addresses)), days)
            why = "was asked for" if renew else authority.why_anew(place, wanted)
            if why:
                authority.issue(place, wanted)
                made.append(participant if authority.made or why == "was missing" else f"{participant} ({why})")
        ends = min(end_of(place) for place in places.values())
    except ValueError as problem:
        refuse(str(problem))
    except OSError as problem:
        refuse(f"{problem.filename}: {problem.strerror}")
    if made:
        signed = "an authority, and certificates" if authority.made else "certificates"
        done = f"made {signed} for {', '.join(made)}; each folder goes to its owner, authority/ to nobody"
    else:
        done = f"nothing to do for {', '.join(places)}"
    typer.echo(f"{done}; valid until {ends:%Y-%m-%d}")
