"""Bridge to a robot under ROS 2 (humble, jazzy), over Zenoh and without ROS installed."""
