"""The ROS master, asked with a time-out: rospy itself waits for one without end."""

from __future__ import annotations

import http.client
import os
import socket
import xmlrpc.client
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from shared.parameters import Refused

PATIENCE = 1.0
"""Longest time [s] for an answer."""


class NoMaster(Exception):
    """It did not answer; the text says what it was asked at, and how it failed."""


@dataclass(frozen=True)
class Graph:
    """Who says and hears what, as the master knows it.

    Attributes:
        publishers, subscribers: names of nodes by topic.
        services: names of those that there are.
        types: by topic, of whoever published last; of a subscriber while nobody publishes.
    """

    publishers: Mapping[str, tuple[str, ...]]
    subscribers: Mapping[str, tuple[str, ...]]
    services: frozenset[str]
    types: Mapping[str, str]


class Master:
    """The master at an address such as ``http://robot:11311``.

    Attributes:
        caller: name of the node that asks.

    Raises:
        Refused: that is no address.
    """

    def __init__(self, uri: str, caller: str) -> None:
        self.uri, self.caller = uri, caller
        try:
            parts = urlsplit(uri)
            self.host, self.port = parts.hostname or "", parts.port or 0
        except ValueError:
            self.host, self.port = "", 0
        if uri.split("://")[0] != "http" or not self.host or not self.port:
            raise Refused(f"ROS_MASTER_URI is {uri!r}, wanted the master's address such as http://robot:11311")
        self._proxy = xmlrpc.client.ServerProxy(uri, transport=_Impatient())

    def ask(self, method: str, *arguments: Any) -> Any:
        """The master's answer to one of the calls of its API.

        Raises:
            NoMaster: it gave none within ``PATIENCE``, or refused.
        """
        try:
            code, text, value = getattr(self._proxy, method)(self.caller, *arguments)
        except (OSError, http.client.HTTPException, xmlrpc.client.Error, ValueError) as problem:
            # Whatever is left on the connection belongs to the question that failed.
            self._proxy("close")()
            raise NoMaster(
                f"no ROS master answers at {self.uri} ({problem}): is the robot on, and is ROS_MASTER_URI its address?"
            ) from None
        if code != 1:
            raise NoMaster(f"the ROS master at {self.uri} refuses {method}: {text}")
        return value

    def graph(self) -> Graph:
        """Who says and hears what now.

        Raises:
            NoMaster: it does not answer.
        """
        publishers, subscribers, services = self.ask("getSystemState")
        types = self.ask("getTopicTypes")
        return Graph(
            {topic: tuple(sorted(nodes)) for topic, nodes in publishers},
            {topic: tuple(sorted(nodes)) for topic, nodes in subscribers},
            frozenset(name for name, _ in services),
            dict(types),
        )

    def way_there(self) -> str:
        """This machine's own address on the way to the master, where nodes of the robot reach it too.

        Raises:
            NoMaster: its name is unknown here.
        """
        try:
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                # Nothing is sent: the system only chooses the way.
                probe.connect((self.host, self.port))
                return str(probe.getsockname()[0])
        except OSError as problem:
            raise NoMaster(
                f"the ROS master's machine {self.host} is unknown here ({problem}): ROS_MASTER_URI"
            ) from None


def own_address_told() -> bool:
    """Whether somebody has said by which address the robot reaches this machine."""
    return bool(os.environ.get("ROS_IP") or os.environ.get("ROS_HOSTNAME"))


class _Impatient(xmlrpc.client.Transport):
    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = PATIENCE
        return connection
