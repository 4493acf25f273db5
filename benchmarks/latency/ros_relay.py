"""One hop over ROS 1: ``/usr/bin/python3 -m benchmarks.latency.ros_relay <from> <to> wrench|twist``."""

from __future__ import annotations

import sys

import rospy
from geometry_msgs.msg import TwistStamped, WrenchStamped


def main() -> None:
    """Relay until SIGTERM."""
    source, target, kind = sys.argv[1:]
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


if __name__ == "__main__":
    main()
