"""The simulated robot itself: arm, base, head, gripper, sensors."""
