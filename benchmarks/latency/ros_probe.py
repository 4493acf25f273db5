"""Source and sink of the ROS 1 relay: ``/usr/bin/python3 -m benchmarks.latency.ros_probe <rate> <seconds>``."""

from __future__ import annotations

import sys
import time

import rospy
from geometry_msgs.msg import TwistStamped, WrenchStamped

from benchmarks.latency.pacing import paced, printed

WARM_UP = 1.0


def main() -> None:
    """Print the latencies [us] as JSON."""
    rate, seconds = float(sys.argv[1]), float(sys.argv[2])
    rospy.init_node("probe")
    puts: list[int] = []
    arrivals: list[int] = []
    publisher = rospy.Publisher("ft", WrenchStamped, queue_size=1, tcp_nodelay=True)
    rospy.Subscriber(
        "twist", TwistStamped, lambda _: arrivals.append(time.monotonic_ns()), queue_size=1, tcp_nodelay=True
    )
    message = WrenchStamped()
    for _ in paced(rate, 1.0):
        publisher.publish(message)
    arrivals.clear()
    for _ in paced(rate, WARM_UP + seconds):
        message.header.stamp = rospy.Time.now()
        puts.append(time.monotonic_ns())
        publisher.publish(message)
    time.sleep(0.2)
    printed(puts, arrivals, puts[0] + round(WARM_UP * 1e9), puts[-1] + 1)


if __name__ == "__main__":
    main()
