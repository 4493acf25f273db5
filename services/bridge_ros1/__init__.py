"""Bridge to a robot under ROS 1 (melodic, noetic), with Debian's rospy."""
