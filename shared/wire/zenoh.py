"""The bus over Zenoh: the only module that knows Zenoh's interface."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import zenoh

from shared.topics import MAP_CAP, TOPICS, topic_by_key
from shared.wire.bus import Leave, NoReply, OnPayload, OnRequest, Work
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError, check_endpoint, next_port

_LEASE_MS = 1000
"""A peer that says nothing for this long is gone; Zenoh's default of ten seconds hides a hung process."""
_LARGEST_MESSAGE = 2 * max(topic.cap for topic in TOPICS)
_RUNTIME = "(app: (worker_threads: 2), net: (handover: app), acc: (handover: app), rx: (handover: app))"
"""One pool of threads for all that Zenoh does but sending: what one pool hands to another wakes a thread, which costs a
fifth of a message's latency. Sending keeps its own, without which large payloads are dropped under load."""
_NEWEST = 16
"""So many of the newest payloads are kept while a thread is busy; what matters is the last, the others are counted."""
_ALIVE = "alive"


def _settings(mode: str) -> dict[str, object]:
    """Settings of every session of the project: explicit endpoints, no multicast, no shared memory, short lease."""
    return {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": _LEASE_MS,
        "transport/link/tx/keep_alive": 4,
        "transport/link/rx/max_message_size": _LARGEST_MESSAGE,
    }


def _prepare() -> None:
    """Say how Zenoh runs in this process, unless the user has; it is read when the first session is opened."""
    os.environ.setdefault("ZENOH_RUNTIME", _RUNTIME)
    zenoh.init_log_from_env_or("off")


def _config(settings: dict[str, object], base: zenoh.Config | None = None) -> zenoh.Config:
    config = base or zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def open_router(listen: str, config_file: Path | None = None) -> zenoh.Session:
    """A Zenoh router inside this process; close it with its ``close``.

    Args:
        listen: endpoint such as ``tcp/127.0.0.1:7447``.
        config_file: Zenoh's own JSON5 configuration, which then decides everything, the endpoint included.

    Raises:
        BusError: if the file cannot be read or the endpoint cannot be listened on.
    """
    _prepare()
    if config_file is not None:
        try:
            config = zenoh.Config.from_file(str(config_file))
        except zenoh.ZError as problem:
            raise BusError(f"--config {config_file}: not a Zenoh configuration ({_first_line(problem)})") from None
    else:
        check_endpoint("--listen", listen)
        config = _config(_settings("router") | {"listen/endpoints": [listen], "listen/exit_on_failure": True})
    try:
        return zenoh.open(config)
    except zenoh.ZError as problem:
        if config_file is not None:
            raise BusError(
                f"--config {config_file}: cannot listen as it says ({_reason(problem)}). Is another router running "
                "there? Choose another port in its listen/endpoints"
            ) from None
        other = next_port(listen)
        raise BusError(
            f"cannot listen on {listen} ({_reason(problem)}). Is another router running there? Choose another "
            f"port with --listen {other} and give every other process --connect {other}"
        ) from None


def _reason(problem: Exception) -> str:
    return "the port is taken" if "Address already in use" in str(problem) else _first_line(problem)


def _first_line(problem: Exception) -> str:
    return str(problem).splitlines()[0].split(" at /")[0][:200]


def _follow(subscriber: zenoh.Subscriber, on_payload: OnPayload, work: Work) -> None:
    """Hand over what arrives and do the work, until the session is closed."""
    while True:
        try:
            sample = subscriber.try_recv()
            behind = sample is not None
            if sample is None:
                sample = subscriber.recv()
            while sample is not None:
                on_payload(sample.payload.to_bytes())
                sample = subscriber.try_recv()
        except zenoh.ZError:
            return
        work(behind)


class ZenohBus:
    """A client of one router, which it waits for and comes back to as long as it lives.

    Args:
        robot: first chunk of every key.
        connect: endpoint of the router.
        give_up: asked a few times per second while there is no router; true ends the waiting.

    Raises:
        BusError: if the endpoint's form is wrong, or there was no router until ``give_up``.
    """

    def __init__(
        self, robot: str = "tiago", connect: str = DEFAULT_ENDPOINT, give_up: Callable[[], bool] = lambda: False
    ) -> None:
        _prepare()
        check_endpoint("--connect", connect)
        settings = _settings("client") | {
            "connect/endpoints": [connect],
            "connect/timeout_ms": 300,
            "connect/exit_on_failure": True,
            "connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5},
        }
        self._session = self._open(_config(settings), connect, give_up)
        self._robot = robot
        self._lock = threading.Lock()
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._declared: list[zenoh.Subscriber | zenoh.Queryable] = []
        self._tokens: dict[str, zenoh.LivelinessToken] = {}
        self._present: dict[int, str] = {}
        self._comings: zenoh.Subscriber | None = None

    @staticmethod
    def _open(config: zenoh.Config, connect: str, give_up: Callable[[], bool]) -> zenoh.Session:
        # Zenoh's own endless waiting cannot be interrupted by a signal; short attempts can.
        while True:
            try:
                return zenoh.open(config)
            except zenoh.ZError as problem:
                if "Unable to connect" not in str(problem):
                    raise BusError(f"--connect {connect}: {_first_line(problem)}") from None
            if give_up():
                raise BusError(f"no router at {connect}. Start one with `tandem up` or `python -m services.router`")

    def _full(self, key: str) -> str:
        return f"{self._robot}/{key}"

    def publish(self, key: str, payload: bytes) -> None:
        """Send a payload to every subscriber of the key; without a router it is dropped."""
        self._publisher(key).put(payload)

    def wanted(self, key: str) -> bool:
        """Whether anybody subscribes to the key at present, as far as the router has told."""
        # Zenoh's own type hints take this for a bool.
        status: Any = self._publisher(key).matching_status
        return bool(status.matching)

    def _publisher(self, key: str) -> zenoh.Publisher:
        publisher = self._publishers.get(key)
        if publisher is None:
            with self._lock:
                # Declared once: the first put of an undeclared key costs a round trip each time.
                publisher = self._publishers[key] = self._declare(key)
        return publisher

    def _declare(self, key: str) -> zenoh.Publisher:
        topic = topic_by_key(key)
        bulky = topic is not None and topic.cap > MAP_CAP
        return self._session.declare_publisher(
            self._full(key),
            encoding=zenoh.Encoding("application/msgpack"),
            # Blocking, a put stands still for seconds behind a hung router, and with it the loop that controls. What
            # must arrive, such as a stop, is repeated until its effect is seen.
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.DATA_LOW if bulky else zenoh.Priority.REAL_TIME,
            express=True,
        )

    def subscribe(self, key: str, on_payload: OnPayload, work: Work | None = None) -> None:
        """Have every payload that arrives under the key handed over, from one of Zenoh's threads.

        With ``work`` the thread is one of this process, which sleeps inside Zenoh until a payload is there: to wake a
        thread costs more than a control tick, so none is woken only to wake another.
        """
        if work is None:
            self.listen(key, on_payload)
            return
        subscriber = self._session.declare_subscriber(self._full(key), zenoh.handlers.RingChannel(_NEWEST))
        self._declared.append(subscriber)
        threading.Thread(target=_follow, args=(subscriber, on_payload, work), name=key, daemon=True).start()

    def listen(self, key: str, on_payload: OnPayload) -> Leave:
        """Subscribe until what is returned is called, from one of Zenoh's threads."""

        def on_sample(sample: zenoh.Sample) -> None:
            on_payload(sample.payload.to_bytes())

        subscriber = self._session.declare_subscriber(self._full(key), on_sample)
        self._declared.append(subscriber)

        def leave() -> None:
            self._declared.remove(subscriber)
            subscriber.undeclare()

        return leave

    def serve(self, key: str, on_request: OnRequest) -> None:
        """Answer queries under the key."""
        full = self._full(key)

        def on_query(query: zenoh.Query) -> None:
            def reply(payload: bytes) -> None:
                # Dropping the query is what tells Zenoh that no more replies come.
                query.reply(full, payload, encoding=zenoh.Encoding("application/msgpack"))
                query.drop()

            request = query.payload.to_bytes() if query.payload is not None else b""
            on_request(request[: MAP_CAP + 1], reply)

        self._declared.append(self._session.declare_queryable(full, on_query))

    def query(self, key: str, payload: bytes, timeout: float) -> bytes:
        """Ask, and wait for the first answer at most ``timeout`` [s].

        Raises:
            NoReply: if none came.
        """
        replies = self._session.get(
            self._full(key), payload=payload, timeout=timeout, encoding=zenoh.Encoding("application/msgpack")
        )
        for reply in replies:
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
        raise NoReply(f"no answer on {self._full(key)} within {timeout:g} s")

    def _on_token(self, sample: zenoh.Sample) -> None:
        name, session = str(sample.key_expr).split("/")[-2:]
        if not session.isdecimal():
            return
        if sample.kind == zenoh.SampleKind.PUT:
            self._present = self._present | {int(session): name}
        else:
            self._present = {key: other for key, other in self._present.items() if key != int(session)}

    def _hold(self, token: str) -> None:
        if token not in self._tokens:
            self._tokens[token] = self._session.liveliness().declare_token(self._full(f"{_ALIVE}/{token}"))

    def claim(self, name: str, session: int) -> Leave:
        """Hold the liveliness token of one start of a participant until what is returned is called."""
        token = f"{name}/{session}"
        self._hold(token)
        return lambda: self._tokens.pop(token).undeclare()

    def alive(self, name: str, session: int) -> None:
        """Hold the liveliness tokens of a service and of this start of it until the bus is closed."""
        self._hold(name)
        self._hold(f"{name}/{session}")

    def living(self) -> set[str]:
        """Names of the services whose token exists."""
        return self._held("*")

    def sessions(self, name: str) -> set[int]:
        """All starts of a participant that hold a token. Before the first ``present`` the router is asked: of two that
        have claimed one and look then, at least one sees the other. Later Zenoh answers by what it has been told.
        """
        return {int(session) for session in self._held(f"{name}/*") if session.isdecimal()}

    def _held(self, tokens: str) -> set[str]:
        """Last chunks of the keys of tokens."""
        replies = self._session.liveliness().get(self._full(f"{_ALIVE}/{tokens}"), timeout=1.0)
        return {str(reply.ok.key_expr).rsplit("/", 1)[1] for reply in replies if reply.ok is not None}

    def present(self) -> Mapping[int, str]:
        """Name of the participant by session, of all that the router has told of since the first call."""
        if self._comings is None:
            every = self._full(f"{_ALIVE}/*/*")
            self._comings = self._session.liveliness().declare_subscriber(every, self._on_token, history=True)
        return self._present

    def connected(self) -> bool:
        """Whether a router is there at present."""
        return bool(self._session.info.routers_zid())

    def close(self) -> None:
        """Leave the bus. Without this a process with subscriptions does not end."""
        self._session.close()
