"""Sessions of Zenoh: router, client, and peer with direct links."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import zenoh

from shared.topics import TOPICS
from shared.wire.access import access
from shared.wire.credentials import Credentials
from shared.wire.endpoint import BusError, NoRouter, check_endpoint, next_port
from shared.wire.links import Links

_LEASE_MS = 1000
"""A peer that says nothing for this long is gone; Zenoh's default of ten seconds hides a hung process."""
_LARGEST_MESSAGE = 2 * max(topic.cap for topic in TOPICS)
_RUNTIME = "(app: (worker_threads: 2), net: (handover: app), acc: (handover: app), rx: (handover: app))"
"""One pool of threads for all that Zenoh does but sending: what one pool hands to another wakes a thread, which costs a
fifth of a message's latency. Sending keeps its own, without which large payloads are dropped under load."""
_RETRY = {"connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5}}
"""A connection that is lost is made again for ever."""
_ROUTER_FIRST = _RETRY | {"connect/timeout_ms": 300, "connect/exit_on_failure": True}
"""Without a router there is an error soon."""


def _settings(mode: str, credentials: Credentials | None) -> dict[str, object]:
    """Settings of every session of the project: explicit endpoints, no multicast, no shared memory, short lease."""
    return (credentials.settings() if credentials else {}) | {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": _LEASE_MS,
        "transport/link/tx/keep_alive": 4,
        "transport/link/rx/max_message_size": _LARGEST_MESSAGE,
    }


def prepare() -> None:
    """Say how Zenoh runs in this process, unless the user has; it is read when the first session is opened."""
    os.environ.setdefault("ZENOH_RUNTIME", _RUNTIME)
    zenoh.init_log_from_env_or("off")


def _config(settings: dict[str, object], base: zenoh.Config | None = None) -> zenoh.Config:
    config = base or zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def router_settings(
    listen: str,
    credentials: Credentials | None = None,
    robots: Sequence[str] = (),
    others: Sequence[str] = (),
) -> dict[str, object]:
    """Settings of a router.

    Args:
        listen: endpoint such as ``tcp/127.0.0.1:7447``.
        credentials: its certificate; with one nobody can do anything but what the certificates of these robots allow.
        robots: first chunks of the keys of the robots that it serves.
        others: endpoints of routers on other machines, which it dials until they are there, and again when lost.

    Raises:
        BusError: if the form of an endpoint is wrong.
    """
    check_endpoint("--listen", listen)
    if credentials:
        credentials.check_endpoint("--listen", listen)
    for other in others:
        check_endpoint("--link", other)
    settings = _settings("router", credentials) | _RETRY
    settings |= {"listen/endpoints": [listen], "listen/exit_on_failure": True, "connect/endpoints": [*others]}
    # What it would wait for half a second is switched off.
    settings["scouting/delay"] = 0
    return settings | ({"access_control": access(robots)} if credentials else {})


def router_file(settings: dict[str, object]) -> str:
    """The settings as a configuration file of Zenoh's, for its standard router."""
    nested: dict[str, Any] = {}
    for path, value in settings.items():
        *above, last = path.split("/")
        table = nested
        for name in above:
            table = table.setdefault(name, {})
        table[last] = value
    return json.dumps(nested, indent=2)


def open_router(settings: dict[str, object] | Path) -> zenoh.Session:
    """A Zenoh router inside this process; close it with its ``close``.

    Args:
        settings: ``router_settings``, or a file in Zenoh's own JSON5, which then decides everything.

    Raises:
        BusError: if the file cannot be read or the endpoint cannot be listened on.
    """
    prepare()
    if isinstance(settings, Path):
        try:
            config = zenoh.Config.from_file(str(settings))
        except zenoh.ZError as problem:
            raise BusError(f"--config {settings}: not a Zenoh configuration ({_first_line(problem)})") from None
    else:
        config = _config(settings)
    try:
        return zenoh.open(config)
    except zenoh.ZError as problem:
        if isinstance(settings, Path):
            raise BusError(
                f"--config {settings}: cannot listen as it says ({_reason(problem)}). Is another router running "
                "there? Choose another port in its listen/endpoints"
            ) from None
        (listen,) = cast(list[str], settings["listen/endpoints"])
        other = next_port(listen)
        raise BusError(
            f"cannot listen on {listen} ({_reason(problem)}). Is another router running there? Choose another "
            f"port with --listen {other} and give every other process --connect {other}"
        ) from None


def _reason(problem: Exception) -> str:
    return "the port is taken" if "Address already in use" in str(problem) else _first_line(problem)


def _first_line(problem: Exception) -> str:
    return str(problem).splitlines()[0].split(" at /")[0][:200]


@dataclass(frozen=True)
class Place:
    """Where a participant is connected.

    Attributes:
        robot: first chunk of every key.
        connect: endpoint of the router.
        credentials: its certificate on a closed network.
    """

    robot: str
    connect: str
    credentials: Credentials | None = None


def open_client(place: Place, give_up: Callable[[], bool]) -> zenoh.Session:
    """A client of one router, which it waits for.

    Args:
        place: where to connect.
        give_up: asked a few times per second while there is no router; true ends the waiting.

    Raises:
        BusError: if the endpoint cannot be used, the certificate is refused, or there was no router until ``give_up``.
    """
    settings = _settings("client", place.credentials) | _ROUTER_FIRST | {"connect/endpoints": [place.connect]}
    return _opened(settings, place, give_up)


def open_peer(place: Place, links: Links, give_up: Callable[[], bool]) -> zenoh.Session:
    """A peer with direct links, and one to the router for whoever is a client; arguments and errors as above.

    Its identity begins with its place in the chain, so that the others know by name who is linked (``linked``).
    """
    dial = [f"{endpoint}#exit_on_failure=false" for endpoint in links.dial]
    settings = _settings("peer", place.credentials) | _ROUTER_FIRST
    settings |= {
        "listen/endpoints": [links.listen],
        # Whoever hung keeps its socket after another has taken its place: that one listens as soon as it is let go.
        "listen/exit_on_failure": False,
        "listen/timeout_ms": -1,
        "connect/endpoints": [f"{place.connect}#exit_on_failure=true", *dial],
    }
    if place.credentials:
        settings["access_control"] = access((place.robot,))
    return _opened(settings, place, give_up, f"{links.names.index(links.own) + 1:x}")


def linked(peers: Iterable[zenoh.ZenohId], links: Links) -> set[str]:
    """Names of the processes of the chain that are among a session's peers."""
    places = {str(peer)[:-16] for peer in peers}
    return {name for place, name in enumerate(links.names, 1) if f"{place:x}" in places}


def _opened(settings: dict[str, object], place: Place, give_up: Callable[[], bool], prefix: str = "") -> zenoh.Session:
    if place.connect.startswith("tls/") and place.credentials is None:
        raise BusError(f"{place.connect} is a closed network: name your certificates with TANDEM_SECURE=FOLDER")
    if place.credentials:
        place.credentials.check_endpoint("--connect", place.connect)
    # Zenoh's own endless waiting cannot be interrupted by a signal; short attempts can.
    while True:
        # Another identity for each attempt: the router may still believe in the link of the one before.
        identity = {"id": f"{prefix}{secrets.randbits(63) | 1 << 63:016x}"}
        try:
            return zenoh.open(_config(settings | identity))
        except zenoh.ZError as problem:
            if "Unable to connect" not in str(problem):
                raise BusError(f"--connect {place.connect}: {_first_line(problem)}") from None
        if place.credentials and (why := place.credentials.why_refused(place.connect)):
            raise BusError(why)
        if give_up():
            raise NoRouter(f"no router at {place.connect}. Start one with `tandem up` or `python -m services.router`")
