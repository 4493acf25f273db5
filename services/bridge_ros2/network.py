"""The robot's own Zenoh network, on which its topics travel: another one than the contract's bus, and not ours.

Only one thread waits for it, in here. Whoever commands the robot only puts what is declared already, and whatever
arrives is handed over by Zenoh's threads, which must not be held up.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import zenoh
from zenoh import ext

from services.bridge_ros2.names import Dialect, End, publisher_of
from services.bridge_ros2.sensors import Arrived
from shared.parameters import Refused
from shared.robot.bridge.late import give_up_late_to
from shared.wire.endpoint import BusError, check_endpoint, port_of
from shared.wire.zenoh_sessions import Place, open_client

NODE = "tandem"
LOOK_EVERY = 0.2  # [s] between two looks at the connection, and at what is wanted


@dataclass(frozen=True)
class Ear:
    """A topic that is listened to.

    Attributes:
        kind: type.
        offer: takes each message, in one of Zenoh's threads.
        latched: late subscribers get the last message.
        wanted: whether it is of use now.
    """

    topic: str
    kind: str
    offer: Callable[[Arrived], None]
    latched: bool = False
    wanted: Callable[[], bool] = lambda: True


class _Outlet:
    """A declared publisher of commands."""

    def __init__(self, publisher: zenoh.Publisher, dialect: Dialect) -> None:
        self._publisher, self._dialect = publisher, dialect
        self._identity, self._number = os.urandom(16), 0

    def put(self, payload: bytes) -> None:
        self._number += 1
        # A source's time is that of day in ROS; nobody here ever reads it.
        attachment = self._dialect.attachment(self._number, time.time_ns(), self._identity)
        self._publisher.put(payload, attachment=attachment)


class Network:
    """A participant of the robot's network, which it waits for and comes back to until it is closed.

    Attributes:
        trouble: why nothing goes to the robot or comes from it; empty while it is connected.
        session: identity of the own session; empty before the first connection.

    Args:
        far: endpoint of the router, or the bridge, on the robot.
        dialect: how topics become keys.
        ears: what to listen to.
        commanded: types by the topics to publish.
        changed: told, in one of Zenoh's threads, that there are other publishers or subscribers.

    Raises:
        Refused: the endpoint has not the form of one.
    """

    def __init__(
        self,
        far: str,
        dialect: Dialect,
        ears: Collection[Ear],
        commanded: Mapping[str, str],
        changed: Callable[[Collection[End]], None],
    ) -> None:
        try:
            check_endpoint("far is", far)
        except BusError as problem:
            raise Refused(str(problem)) from None
        self._far, self._dialect, self._ears, self._commanded, self._changed = far, dialect, ears, commanded, changed
        self._outlets: dict[str, _Outlet] = {}
        self._ends: dict[str, End] = {}
        self._subscribers: dict[str, zenoh.Subscriber | ext.AdvancedSubscriber] = {}
        self._closed = threading.Event()
        self.session = ""
        self.trouble = self._away = (
            f"nobody answers at {far}: is the robot's Zenoh router or bridge up, and is far its address?"
        )
        self._thread = threading.Thread(target=self._run, name="far side", daemon=True)
        self._thread.start()

    @property
    def ends(self) -> Collection[End]:
        """Whoever else publishes and subscribes on the network, as of now."""
        return self._ends.values()

    def send(self, topic: str, payload: bytes) -> None:
        """Publish; dropped while there is no network, or while it takes nothing more."""
        outlet = self._outlets.get(topic)
        if outlet is not None:
            try:
                outlet.put(payload)
            except zenoh.ZError as problem:
                if not self._closed.is_set():
                    self.trouble = f"Zenoh does not send to {self._far}: {str(problem).splitlines()[0][:100]}"

    def close(self) -> None:
        """Leave the network."""
        self._closed.set()
        self._outlets = {}
        self._thread.join()

    def _run(self) -> None:
        try:
            session = open_client(Place("", self._far), self._closed.is_set)
        except BusError as problem:
            self.trouble = self.trouble if self._closed.is_set() else str(problem)
            return
        try:
            self.session = str(session.info.zid())
            # They live as long as somebody holds them.
            held = self._declare(session)
            while held and not self._closed.is_set():
                self.trouble = "" if [*session.info.routers_zid(), *session.info.peers_zid()] else self._away
                self._follow_demand(session)
                give_up_late_to(port_of(self._far))
                self._closed.wait(LOOK_EVERY)
        except zenoh.ZError as problem:
            self.trouble = f"Zenoh gives up {self._far}: {str(problem).splitlines()[0][:100]}"
        finally:
            session.close()

    def _declare(self, session: zenoh.Session) -> list[object]:
        dialect, liveliness = self._dialect, session.liveliness()
        for topic, kind in self._commanded.items():
            publisher = session.declare_publisher(
                dialect.commanded(topic, kind),
                encoding=zenoh.Encoding("application/cdr"),
                # What cannot go now must not go later, and nobody who controls waits.
                congestion_control=zenoh.CongestionControl.DROP,
                priority=zenoh.Priority.REAL_TIME,
                express=True,
            )
            self._outlets = self._outlets | {topic: _Outlet(publisher, dialect)}
        heard = {ear.topic: ear.kind for ear in self._ears}
        tokens = dialect.tokens(self.session, NODE, heard, self._commanded)
        return [
            liveliness.declare_subscriber(dialect.graph, self._on_token, history=True),
            *(liveliness.declare_token(key) for key in tokens),
        ]

    def _follow_demand(self, session: zenoh.Session) -> None:
        for ear in self._ears:
            if ear.wanted() == (ear.topic in self._subscribers):
                continue
            if ear.topic in self._subscribers:
                self._subscribers.pop(ear.topic).undeclare()
            else:
                self._subscribers[ear.topic] = self._subscribed(session, ear)

    def _subscribed(self, session: zenoh.Session, ear: Ear) -> zenoh.Subscriber | ext.AdvancedSubscriber:
        key, dialect = self._dialect.heard(ear.topic), self._dialect

        def on_sample(sample: zenoh.Sample) -> None:
            attached = sample.attachment
            sender = publisher_of(attached.to_bytes() if attached is not None else None)
            ear.offer(Arrived(sample.payload.to_bytes(), dialect.kind_of(str(sample.key_expr)), sender))

        if not ear.latched:
            return session.declare_subscriber(key, on_sample)
        # A plain subscriber that comes late gets nothing of what was latched.
        history = ext.HistoryConfig(detect_late_publishers=True)
        return ext.declare_advanced_subscriber(session, key, on_sample, history=history)

    def _on_token(self, sample: zenoh.Sample) -> None:
        token = str(sample.key_expr)
        if sample.kind == zenoh.SampleKind.PUT:
            end = self._dialect.end(token)
            if end is not None and end.session != self.session:
                self._ends = self._ends | {token: end}
        else:
            self._ends = {key: end for key, end in self._ends.items() if key != token}
        self._changed(self.ends)
