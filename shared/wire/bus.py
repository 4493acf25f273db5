"""Interface of a message bus: a handful of methods that the Zenoh bus and the in-process bus share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

OnPayload = Callable[[bytes], None]
Reply = Callable[[bytes], None]
OnRequest = Callable[[bytes, Reply], None]
Work = Callable[[bool], None]
Leave = Callable[[], None]


class NoReply(TimeoutError):
    """Nobody answered a query in time."""


class Bus(Protocol):
    """Keys are without the robot's prefix. Callbacks come from any thread and have to return at once."""

    def publish(self, key: str, payload: bytes) -> None:
        """Send a payload to every subscriber of the key."""
        ...

    def wanted(self, key: str) -> bool:
        """Whether anybody subscribes to the key at present."""
        ...

    def subscribe(self, key: str, on_payload: OnPayload, work: Work | None = None) -> None:
        """Have every payload that arrives under the key handed over.

        Args:
            key: without the robot's prefix.
            on_payload: given each payload; has to return at once.
            work: called after whatever has arrived was handed over, in a thread in which it may take its time and use
                the bus. It is told whether some of it arrived while the work before still lasted.
        """
        ...

    def listen(self, key: str, on_payload: OnPayload) -> Leave:
        """Subscribe for a while.

        Returns:
            What ends it; a payload that is on its way by then may still be handed over.
        """
        ...

    def serve(self, key: str, on_request: OnRequest) -> None:
        """Answer queries under the key; the reply may be given later, from any thread."""
        ...

    def query(self, key: str, payload: bytes, timeout: float) -> bytes:
        """Ask, and wait for the first answer at most ``timeout`` [s].

        Raises:
            NoReply: if none came.
        """
        ...

    def claim(self, name: str, session: int) -> Leave:
        """Hold the liveliness token of one start of a participant, by which two of a kind are told apart.

        Returns:
            What gives it back.
        """
        ...

    def alive(self, name: str, session: int) -> None:
        """Hold the liveliness tokens of a service and of this start of it until the bus is closed."""
        ...

    def living(self) -> set[str]:
        """Names of the services whose token exists."""
        ...

    def sessions(self, name: str) -> set[int]:
        """All starts of a participant that hold a token, asked of the network."""
        ...

    def present(self) -> Mapping[int, str]:
        """Name of the participant by session, of all that the network has told of so far; asks nobody."""
        ...

    def connected(self) -> bool:
        """Whether there is a way to the others at present."""
        ...

    def links(self) -> dict[str, bool]:
        """Whether there is a direct link to each other process of the chain; empty if none is wanted."""
        ...

    def cut_off(self) -> str:
        """Why nobody but the other processes of the chain can reach this one; empty if they can."""
        ...

    def close(self) -> None:
        """Leave the bus; later calls are an error."""
        ...
