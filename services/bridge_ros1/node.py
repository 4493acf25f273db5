"""This process as a node of ROS 1: one thread does everything that may wait for the master.

rospy registers each topic once. A master that was restarted knows nobody, and a connection that broke is made anew only
when the master says so: so what the master lacks is told to it again, and the node again whom it should hear.
"""

from __future__ import annotations

import os
import threading
import time
import xmlrpc.client
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from services.bridge_ros1.commands import Outlet
from services.bridge_ros1.master import Graph, Master, NoMaster, own_address_told
from services.bridge_ros1.names import message_class

EVERY = 0.5
"""Time [s] between two looks at the master."""
STALE = 3.0
"""Time [s] of silence after which a connection is made anew: TCP tries ever more rarely on a way that was cut."""
_LARGE = 1 << 22  # [bytes] of a buffer, into which several images fit
_END_WITHIN = 1.2  # [s], before the process has to end


@dataclass(eq=False)
class Ear:
    """A topic that the robot publishes.

    Attributes:
        topic, kind: its name and the type of its messages.
        hear: called with each message, in a thread of its publisher.
        wanted: whether it is of use now.
        forget: called when it no longer is.
        large: its messages are images.
        shared: it may have several publishers.
        silence: for how long [s] nothing has been heard of a topic that never falls silent; 0 of any other.
    """

    topic: str
    kind: str
    hear: Callable[[Any], None]
    wanted: Callable[[], bool] = lambda: True
    forget: Callable[[], None] = lambda: None
    large: bool = False
    shared: bool = False
    silence: Callable[[], float] = lambda: 0.0
    subscriber: Any = None
    subscribed: float = 0.0

    @property
    def publishers(self) -> int:
        """How many are connected."""
        return self.subscriber.get_num_connections() if self.subscriber else 0


class Node:
    """A node that hears and says what it is told to, from when there is a master on.

    Attributes:
        graph: who says and hears what, as of the last look; None before the first one.
        trouble: why there is no connection to ROS; empty if there is one.

    Args:
        master: of the robot.
        name: of the node, without what makes it unique.
        ears, outlets: what it hears and says.
        look: called after each look at the master, in the same thread.
        leave: called there before the node ends.
        ports: first of the two at which other nodes reach it; 0 for any free ones.
    """

    def __init__(
        self,
        master: Master,
        name: str,
        ears: Sequence[Ear],
        outlets: Sequence[Outlet],
        look: Callable[[Graph], None],
        leave: Callable[[], None],
        ports: int = 0,
    ) -> None:
        self.graph: Graph | None = None
        self.trouble = f"no ROS master has answered at {master.uri} yet"
        self._master, self._name = master, name
        self._ears, self._outlets = ears, outlets
        self._look, self._leave = look, leave
        self._ports = {"xmlrpc_port": ports, "tcpros_port": ports + 1} if ports else {}
        self._started, self._closing = False, False
        self._wake = threading.Event()
        # Threads that rospy starts from here are daemons, too: one that waits for the robot holds no process up.
        self._thread = threading.Thread(target=self._run, name="ros node", daemon=True)
        self._thread.start()

    def wake(self) -> None:
        """Look at once: something else is wanted."""
        self._wake.set()

    def close(self) -> None:
        """Leave ROS, as far as it lets the process go in time."""
        self._closing = True
        self._wake.set()
        self._thread.join(_END_WITHIN)

    def _run(self) -> None:
        while not self._closing:
            try:
                self._turn()
            except NoMaster as problem:
                self.trouble = str(problem)
            except Exception as problem:
                # Whatever else fails inside rospy is tried again like a master that is away, and named.
                self.trouble = f"rospy fails: {type(problem).__name__}: {problem}"
            self._wake.wait(EVERY)
            self._wake.clear()
        if self._started:
            import rospy

            self._leave()
            rospy.signal_shutdown("the bridge ends")

    def _turn(self) -> None:
        if self._ended():
            self.trouble = self._ended()
            return
        graph = self._master.graph()
        if not self._started:
            self._start()
        self._adjust(graph)
        self.graph = graph
        self._look(graph)
        self.trouble = ""

    def _start(self) -> None:
        import rospy

        if not own_address_told():
            # The robot's nodes connect to what this one says that it is called, and seldom know a laptop by its name.
            os.environ["ROS_IP"] = self._master.way_there()
        os.environ["ROS_MASTER_URI"] = self._master.uri
        with _logging_left_alone():
            options = {"anonymous": True, "disable_rosout": True, "disable_signals": True, **self._ports}
            rospy.init_node(self._name, argv=[self._name], **options)
        self._master.caller = rospy.get_name()
        self._started = True

    def _adjust(self, graph: Graph) -> None:
        """Have the subscribers and publishers that are to be, and the master know them."""
        import rospy

        own = rospy.get_name()
        for ear in self._ears:
            if ear.wanted() and ear.subscriber is None:
                size = {"buff_size": _LARGE} if ear.large else {}
                ear.subscriber = rospy.Subscriber(
                    ear.topic, message_class(ear.kind), ear.hear, queue_size=1, tcp_nodelay=True, **size
                )
                ear.subscribed = time.monotonic()
            elif not ear.wanted() and ear.subscriber is not None:
                ear.subscriber.unregister()
                ear.subscriber = None
                ear.forget()
            elif ear.subscriber is not None and min(ear.silence(), time.monotonic() - ear.subscribed) > STALE:
                # The master is there, or nobody would look.
                ear.subscriber.unregister()
                ear.subscriber = None
                self._wake.set()
            elif ear.subscriber is not None:
                known = own in graph.subscribers.get(ear.topic, ())
                if not known or ear.publishers < len(graph.publishers.get(ear.topic, ())):
                    self._register_again(ear)
        for outlet in self._outlets:
            # Whoever registers first gives the topic its type, as the master tells it: a robot with another one is
            # found before that.
            if graph.types.get(outlet.topic, outlet.kind) != outlet.kind:
                continue
            if outlet.is_open and own not in graph.publishers.get(outlet.topic, ()):
                self._master.ask("registerPublisher", outlet.topic, outlet.kind, rospy.get_node_uri())
            outlet.open()
            outlet.give_up_late()

    def _register_again(self, ear: Ear) -> None:
        import rospy

        own = rospy.get_node_uri()
        publishers = self._master.ask("registerSubscriber", ear.topic, ear.kind, own)
        # As the master does when a publisher comes: the node connects to those that it has no connection to.
        xmlrpc.client.ServerProxy(own).publisherUpdate("/master", ear.topic, publishers)

    def _ended(self) -> str:
        """Why there is no way back to ROS in this process; empty if there is."""
        import rospy

        if self._started and rospy.is_shutdown():
            return f"somebody has shut the node {rospy.get_name()} down: start the bridge again"
        return ""


@contextmanager
def _logging_left_alone() -> Iterator[None]:
    """Keeps rospy from putting files in the place of this process' own handlers."""
    import rospy.core

    kept = rospy.core.configure_logging
    rospy.core.configure_logging = lambda *_, **__: None
    try:
        yield
    finally:
        rospy.core.configure_logging = kept
