"""Endpoints of routers: what they look like, and what is said when one will not do."""

from __future__ import annotations

import re

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
_ENDPOINT = re.compile(r"(tcp|tls|udp|quic|ws)/[^?#]+:(?P<port>\d{1,5})([?#].*)?")


class BusError(Exception):
    """The bus cannot be opened as asked; the text is one line for the user."""


class NoRouter(BusError):
    """Nobody routes there, as far as can be seen."""


def check_endpoint(option: str, endpoint: str) -> None:
    """Hold an endpoint against the form that it has to have.

    Raises:
        BusError: it has another; the text names the option.
    """
    form = _ENDPOINT.fullmatch(endpoint)
    if not form or not 0 < int(form["port"]) < 65536:
        raise BusError(
            f"{option} {endpoint}: wanted <protocol>/<address>:<port>, such as {DEFAULT_ENDPOINT}, port 1 to 65535"
        )


def port_of(endpoint: str) -> int:
    """The port of an endpoint that has been checked."""
    form = _ENDPOINT.fullmatch(endpoint)
    assert form is not None
    return int(form["port"])


def next_port(endpoint: str) -> str:
    """The same endpoint with the next port."""
    form = _ENDPOINT.fullmatch(endpoint)
    assert form is not None
    port = int(form["port"])
    other = str(port + 1 if port < 65535 else 7447)
    return endpoint[: form.start("port")] + other + endpoint[form.end("port") :]
