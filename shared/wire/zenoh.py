"""The bus over Zenoh."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping

import zenoh

from shared.topics import MAP_CAP, topic_by_key
from shared.wire.bus import Leave, NoReply, OnPayload, OnRequest, Work
from shared.wire.credentials import Credentials
from shared.wire.endpoint import DEFAULT_ENDPOINT, BusError, check_endpoint
from shared.wire.links import Links
from shared.wire.router_watch import RouterWatch
from shared.wire.zenoh_renewable import Renewable
from shared.wire.zenoh_sessions import Place, linked, open_client, open_peer, prepare

_NEWEST = 16
"""So many of the newest payloads are kept while a thread is busy; what matters is the last, the others are counted."""
_ALIVE, _BEAT = "alive", "beat"
_AGAIN = 1.0  # [s] between two attempts to make the links anew with a certificate that is refused


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


def _bulky(key: str) -> bool:
    topic = topic_by_key(key)
    return topic is not None and topic.cap > MAP_CAP


class ZenohBus:
    """A participant at one router, which it waits for and comes back to as long as it lives.

    With direct links what is small is said and heard in a session of its own: over the links, and through the router to
    and from clients. Images, queries and liveliness tokens go through the router in any case: nothing slow shares a
    session with control, and two processes of one kind, which have no link, see each other.

    Args:
        robot: first chunk of every key.
        connect: endpoint of the router.
        give_up: asked a few times per second while there is no router; true ends the waiting.
        links: direct links to the other processes of the chain, if it belongs to it.
        watched: whether ``cut_off`` is to tell of a router that does not hand on anything any more, which direct links
            outlive.
        credentials: its certificate on a closed network.

    Raises:
        BusError: if the endpoint's form is wrong, or there was no router until ``give_up``.
    """

    def __init__(
        self,
        robot: str = "tiago",
        connect: str = DEFAULT_ENDPOINT,
        give_up: Callable[[], bool] = lambda: False,
        links: Links | None = None,
        watched: bool = False,
        credentials: Credentials | None = None,
    ) -> None:
        prepare()
        check_endpoint("--connect", connect)
        self._place, self._links, self._watched = Place(robot, connect, credentials), links, watched
        self._session = open_client(self._place, give_up)
        self._client = self._control = Renewable(self._session, self._publisher)
        self._robot = robot
        self._relinking, self._closed = threading.Lock(), threading.Event()
        self._tokens: dict[str, zenoh.LivelinessToken] = {}
        self._present: dict[int, str] = {}
        self._comings: zenoh.Subscriber | None = None
        self._watch: RouterWatch | None = None

    def link(self, give_up: Callable[[], bool] = lambda: False) -> None:
        """Make the direct links, before anything is said or heard.

        Not sooner than it is known that this is the only process of its kind: two of a kind would both be peers of the
        router without a link between them, and it hands on nothing reliably then.

        Raises:
            BusError: as the constructor.
        """
        if self._links is None:
            return
        self._control = Renewable(open_peer(self._place, self._links, give_up), self._publisher)
        if self._watched:
            # By the way that a stop takes: only the router connects the two sessions.
            key = self._full(f"{_BEAT}/{self._session.info.zid()}")
            beat = self._session.declare_publisher(key, congestion_control=zenoh.CongestionControl.DROP, express=True)
            watch = self._watch = RouterWatch(self.connected, lambda: beat.put(b""))
            self._control.declare(lambda session: session.declare_subscriber(key, lambda sample: watch.heard()))

    def link_anew(self) -> None:
        """Have the direct links made again, aside, with the certificate that is in its files now.

        Zenoh reads them when a session begins to listen, and never again. Silence until the links stand, about a
        second: whoever reads brakes, and goes on by itself.
        """
        if self._links is not None:
            threading.Thread(target=self._link_anew, args=(self._links,), name="link anew", daemon=True).start()

    def _link_anew(self, links: Links) -> None:
        with self._relinking:
            # First: two sessions of one process would be two of its kind (``link``).
            self._control.close()
            while not self._closed.is_set():
                try:
                    self._control.renew(open_peer(self._place, links, self._closed.is_set))
                    break
                except BusError:
                    # Why the router does not take it is said by whoever finds out (``renewal.Lost``).
                    self._closed.wait(_AGAIN)
        if self._closed.is_set():
            self._control.close()

    def _of(self, key: str) -> Renewable:
        """The session for messages of a key."""
        return self._client if _bulky(key) else self._control

    def _full(self, key: str) -> str:
        return f"{self._robot}/{key}"

    def publish(self, key: str, payload: bytes) -> None:
        """Send a payload to every subscriber of the key; without a router it is dropped."""
        self._of(key).put(key, payload)

    def wanted(self, key: str) -> bool:
        """Whether anybody subscribes to the key at present, as far as the router has told."""
        return self._of(key).wanted(key)

    def _publisher(self, session: zenoh.Session, key: str) -> zenoh.Publisher:
        return session.declare_publisher(
            self._full(key),
            encoding=zenoh.Encoding("application/msgpack"),
            # Blocking, a put stands still for seconds behind a hung router, and with it the loop that controls. What
            # must arrive, such as a stop, is repeated until its effect is seen.
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.DATA_LOW if _bulky(key) else zenoh.Priority.REAL_TIME,
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

        def followed(session: zenoh.Session) -> zenoh.Subscriber:
            subscriber = session.declare_subscriber(self._full(key), zenoh.handlers.RingChannel(_NEWEST))
            threading.Thread(target=_follow, args=(subscriber, on_payload, work), name=key, daemon=True).start()
            return subscriber

        self._of(key).declare(followed)

    def listen(self, key: str, on_payload: OnPayload) -> Leave:
        """Subscribe until what is returned is called, from one of Zenoh's threads."""

        def on_sample(sample: zenoh.Sample) -> None:
            on_payload(sample.payload.to_bytes())

        return self._of(key).declare(lambda session: session.declare_subscriber(self._full(key), on_sample))

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

        self._client.declare(lambda session: session.declare_queryable(full, on_query, complete=True))

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
        return bool(self._control.ask(zenoh.SessionInfo.routers_zid))

    def cut_off(self) -> str:
        """Why nobody but the processes of the chain can reach this one; empty if they can, or if it is not watched."""
        return self._watch.reason() if self._watch else ""

    def links(self) -> dict[str, bool]:
        """Whether there is a direct link to each other process of the chain."""
        if self._links is None:
            return {}
        there = linked(self._control.ask(zenoh.SessionInfo.peers_zid), self._links)
        return {name: name in there for name in self._links.others}

    def close(self) -> None:
        """Leave the bus. Without this a process with subscriptions does not end."""
        self._closed.set()
        if self._watch:
            self._watch.close()
        self._control.close()
        self._client.close()
