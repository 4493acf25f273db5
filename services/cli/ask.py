"""Asking a query of a running service; a refusal or silence ends the command with one line."""

from __future__ import annotations

from typing import Any

from services.cli.refusal import refuse
from shared.parameters import Refused
from shared.topics import Query
from shared.wire.bus import Bus, NoReply
from shared.wire.client import Client


def ask(bus: Bus, query: Query, request: dict[str, Any], timeout: float = 3.0) -> dict[str, Any]:
    """The reply; waits at most `timeout` [s]."""
    try:
        return Client(bus).ask(query, request, timeout)
    except NoReply:
        refuse(
            f"no answer on {query.key} within {timeout:g} s: is {query.server} running? See: tandem status", 1
        )
    except Refused as problem:
        refuse(f"{query.server} refused: {problem}", 1)
