"""As many hops over ROS 1, and their source and sink, both for the system's own Python.

``python3 -m benchmarks.latency.ros hop <from> <to> wrench|twist`` and ``... probe <rate> <seconds>``.
"""

from __future__ import annotations

import sys
import time

import rospy
from geometry_msgs.msg import TwistStamped, WrenchStamped

from benchmarks.latency.pacing import paced, probed


def hop(source: str, target: str, kind: str) -> None:
    """Relay until SIGTERM."""
    rospy.init_node("relay", anonymous=True)
    outgoing = {"wrench": WrenchStamped, "twist": TwistStamped}[kind]
    publisher = rospy.Publisher(target, outgoing, queue_size=1, tcp_nodelay=True)
    message = outgoing()

    def relay(received: WrenchStamped) -> None:
        message.header.stamp = received.header.stamp
        publisher.publish(message)

    rospy.Subscriber(source, WrenchStamped, relay, queue_size=1, tcp_nodelay=True)
    print("ready", flush=True)
    rospy.spin()


def probe(rate: str, seconds: str) -> None:
    """Print the latencies [us] as JSON."""
    rospy.init_node("probe")
    arrivals: list[int] = []
    publisher = rospy.Publisher("ft", WrenchStamped, queue_size=1, tcp_nodelay=True)
    rospy.Subscriber(
        "twist", TwistStamped, lambda _: arrivals.append(time.monotonic_ns()), queue_size=1, tcp_nodelay=True
    )
    message = WrenchStamped()
    for _ in paced(float(rate), 1.0):
        publisher.publish(message)
    arrivals.clear()

    def put() -> None:
        message.header.stamp = rospy.Time.now()
        publisher.publish(message)

    probed(float(rate), float(seconds), put, arrivals)


if __name__ == "__main__":
    {"hop": hop, "probe": probe}[sys.argv[1]](*sys.argv[2:])
