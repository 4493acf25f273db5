"""Simulated dual-arm TIAGo that speaks the robot's side of the Zenoh contract."""
