"""Gate, numbers and description of the robot, for every robot process, simulated or real."""
